#include <algorithm>
#include <cctype>
#include <cstdio>
#include <functional>
#include <memory>
#include <sstream>
#include <string>

#include "pipeline/cli/arguments/argument_parser.h"
#include "pipeline/cli/commands.h"
#include "pipeline/config/options.h"
#include "pipeline/data/error.h"
#include "pipeline/data/number_text.h"

namespace hexrelief::cli {
namespace {

// Returns the text in single quotes, which all three shells read alike; `quote` replaces single quotes in it.
std::string quoted(const std::string& text, const std::string& quote) {
    return "'" + replaced(text, '\'', quote) + "'";
}

// Returns the words of a value's name that stand for themselves: "all" of "all|N".
std::vector<std::string> literals_of(const std::string& value) {
    std::vector<std::string> words;
    std::istringstream parts(value.find('|') == std::string::npos ? "" : value);
    for (std::string part; std::getline(parts, part, '|');)
        if (std::ranges::all_of(part, [](char c) { return std::islower(c) || c == '-'; }))
            words.push_back(part);
    return words;
}

std::string choices_of(const OptionDescription& option) {
    const std::string& name = option.names.back();
    std::vector<std::string> words = literals_of(option.value);
    for (const config::Field* row : config::rows_of_option(name)) words = row->choices;
    if (name == "--config")
        for (const config::Preset& preset : config::presets()) words.push_back(preset.name);
    if (name == "--set")
        for (const config::Field& field : config::config_fields()) {
            std::vector<std::string> values = field.choices;
            if (field.type == config::FieldType::boolean) values = {"true", "false"};
            if (values.empty()) values = {""};
            for (const std::string& value : values) words.push_back(field.path + "=" + value);
        }
    return joined(words, " ");
}

// Visits each command with its full name below the program: "", "run", "tiles run".
using Visitor = std::function<void(const CommandDescription&, const std::string& path)>;
void visit(const CommandDescription& command, const std::string& path, const Visitor& visitor) {
    visitor(command, path);
    for (const CommandDescription& sub : command.commands)
        visit(sub, path + (path.empty() ? "" : " ") + sub.name, visitor);
}

std::vector<std::string> offered_words(const CommandDescription& command) {
    std::vector<std::string> words;
    for (const CommandDescription& sub : command.commands) words.push_back(sub.name);
    for (const OptionDescription& option : command.options) {
        const std::vector<std::string> more = option.is_positional ? literals_of(option.value) : option.names;
        words.insert(words.end(), more.begin(), more.end());
    }
    return words;
}

std::string bash_script(const CommandDescription& program) {
    std::string paths, words, values;
    visit(program, "", [&](const CommandDescription& command, const std::string& path) {
        if (!path.empty()) paths += (paths.empty() ? "" : "|") + quoted(path, "");
        words += "        " + quoted(path, "") +
                 ") words=" + quoted(joined(offered_words(command), " "), "") + " ;;\n";
        for (const OptionDescription& option : command.options) {
            if (option.is_positional || option.value.empty()) continue;
            const std::string names = joined(
                option.names, "|", [&](const std::string& name) { return quoted(path + " " + name, ""); });
            const std::string choices = choices_of(option);
            values += "        " + names + ") " +
                      (choices.empty() ? "values=-" : "values=" + quoted(choices, "")) + " ;;\n";
        }
    });
    return "# bash completion of hexrelief, made by `hexrelief completion bash`\n"
           "_hexrelief() {\n"
           "    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} path= words= values= "
           "cut= i\n"
           "    for ((i = 1; i < COMP_CWORD; ++i)); do\n"
           "        case \"${path:+$path }${COMP_WORDS[i]}\" in\n"
           "        " +
           paths +
           ") path=${path:+$path }${COMP_WORDS[i]} ;;\n"
           "        esac\n"
           "    done\n"
           "    case $path in\n" +
           words +
           "    esac\n"
           "    # Bash parts words at =, so that the value of --set KEY=VALUE is a word of its own.\n"
           "    if [[ $word == = ]]; then word= cut=$before=; elif [[ $before == = ]]; then "
           "cut=${COMP_WORDS[COMP_CWORD-2]}=; fi\n"
           "    if [[ $cut == -* ]]; then before=${cut%=} cut=; elif [[ -n $cut ]]; then before=--set "
           "word=$cut$word; fi\n"
           "    case \"$path $before\" in\n" +
           values +
           "    esac\n"
           "    COMPREPLY=()\n"
           "    if [[ -n $values ]]; then\n"
           "        [[ $values == - ]] || mapfile -t COMPREPLY < <(compgen -W \"$values\" -- \"$word\")\n"
           "        [[ ${COMPREPLY[0]-} != *= ]] || compopt -o nospace\n"
           "        [[ $before == --set || ${#COMPREPLY[@]} -gt 0 ]] || mapfile -t COMPREPLY < <(compgen -f "
           "-- \"$word\")\n"
           "    else\n"
           "        mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$word\")\n"
           "        [[ ${#COMPREPLY[@]} -gt 0 ]] || mapfile -t COMPREPLY < <(compgen -f -- \"$word\")\n"
           "    fi\n"
           "    COMPREPLY=(\"${COMPREPLY[@]#\"$cut\"}\")\n"
           "}\n"
           "complete -o filenames -F _hexrelief hexrelief\n";
}

std::string zsh_values(const OptionDescription& option) {
    const std::string choices = choices_of(option);
    return choices.empty() ? "_files" : "(" + choices + ")";
}

std::string zsh_option(const OptionDescription& option, const std::string& name) {
    std::string help;
    for (const char c : option.help)
        help += (c == '[' || c == ']' || c == '\\' ? "\\" : "") + std::string(1, c);
    std::string spec = (option.is_repeated ? "*" : "") + name + "[" + help + "]";
    if (!option.value.empty()) {
        const std::string choices = choices_of(option);
        spec += ":" + replaced(option.value, ':', "\\:") + ":";
        if (option.names.back() == "--config")
            spec += "{ compadd " + choices + "; _files }";
        else
            spec += zsh_values(option);
    }
    return spec;
}

std::string zsh_function(const std::string& path) {
    return "_hexrelief" + (path.empty() ? "" : "_" + replaced(replaced(path, ' ', "_"), '-', "_"));
}

std::string zsh_script(const CommandDescription& program) {
    std::string text = "#compdef hexrelief\n# made by `hexrelief completion zsh`\n";
    visit(program, "", [&](const CommandDescription& command, const std::string& path) {
        text += zsh_function(path) + "() {\n    local context state line\n    _arguments -C";
        for (const OptionDescription& option : command.options)
            for (const std::string& name : option.names)
                text += " \\\n        " + quoted(option.is_positional ? "*:" + name + ":" + zsh_values(option)
                                                                      : zsh_option(option, name),
                                                 "'\\''");
        if (command.commands.empty()) {
            text += "\n}\n";
            return;
        }
        text +=
            " \\\n        '1:command:->command' '*::argument:->argument'\n    case $state in\n    command)\n"
            "        local -a commands=(";
        for (const CommandDescription& sub : command.commands)
            text += " \\\n            " + quoted(sub.name + ":" + replaced(sub.help, ':', "\\:"), "'\\''");
        text += ")\n        _describe command commands ;;\n    argument)\n        case $line[1] in\n";
        for (const CommandDescription& sub : command.commands)
            text += "        " + sub.name + ") " + zsh_function(path + (path.empty() ? "" : " ") + sub.name) +
                    " ;;\n";
        text += "        esac ;;\n    esac\n}\n";
    });
    return text + "_hexrelief \"$@\"\n";
}

std::string fish_script(const CommandDescription& program) {
    std::string text = "# made by `hexrelief completion fish`\n";
    visit(program, "", [&](const CommandDescription& command, const std::string& path) {
        std::string condition, subs;
        for (const CommandDescription& sub : command.commands) subs += " " + sub.name;
        std::string part;
        for (const char c : path + " ")
            if (c != ' ') {
                part += c;
            } else if (!part.empty()) {
                condition +=
                    (condition.empty() ? "" : "; and ") + std::string("__fish_seen_subcommand_from ") + part;
                part.clear();
            }
        const std::string inside = condition.empty() ? "" : condition + "; and ";
        const std::string begin = "complete -c hexrelief";
        const std::string here = subs.empty() ? condition : inside + "not __fish_seen_subcommand_from" + subs;
        for (const CommandDescription& sub : command.commands)
            text += begin + " -n " + quoted(here, "\\'") + " -f -a " + sub.name + " -d " +
                    quoted(sub.help, "\\'") + "\n";
        for (const OptionDescription& option : command.options) {
            const std::string literals = joined(literals_of(option.value), " ");
            if (option.is_positional && !literals.empty())
                text += begin + " -n " + quoted(here, "\\'") + " -f -a " + quoted(literals, "\\'") + "\n";
            if (option.is_positional) continue;
            text += begin + " -n " + quoted(here, "\\'");
            for (const std::string& name : option.names)
                text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
            const std::string choices = choices_of(option);
            if (!option.value.empty()) {
                const bool takes_files = choices.empty() || option.names.back() == "--config";
                text += takes_files ? " -r" : " -x";
                if (!choices.empty()) text += " -a " + quoted(choices, "\'");
            }
            text += " -d " + quoted(option.help, "\\'") + "\n";
        }
    });
    return text;
}

// Returns a script for "bash", "zsh" or "fish". Throws Error(usage) for another shell.
std::string completion_script(const CommandDescription& program, const std::string& shell) {
    if (shell == "bash") return bash_script(program);
    if (shell == "zsh") return zsh_script(program);
    if (shell == "fish") return fish_script(program);
    throw Error(ErrorKind::usage, "there are completions for bash, zsh and fish, not for '" + shell + "'");
}

}  // namespace

void add_completion_command(Command& program) {
    Command command = program.add_command("completion", "what a shell offers while commands are typed");
    const auto shell = std::make_shared<std::string>();
    command.add_option("SHELL", shell.get(), "what the script is for",
                       {.value = "bash|zsh|fish", .required = true});
    command.set_footer(R"(Examples:
  source <(hexrelief completion bash)
  hexrelief completion fish > ~/.config/fish/completions/hexrelief.fish)");
    command.set_action([shell, program] {
        std::fputs(completion_script(program.describe(), *shell).c_str(), stdout);
        return 0;
    });
}

}  // namespace hexrelief::cli
