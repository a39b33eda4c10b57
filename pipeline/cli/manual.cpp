#include "pipeline/cli/manual.h"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <memory>
#include <sstream>

#include "exporters/core/file_transaction.h"
#include "pipeline/cli/commands.h"
#include "pipeline/data/error.h"

namespace hexrelief::cli {
namespace {

// Escapes text for roff: no line is a request, and dashes are typed ones.
std::string roff(const std::string& text) {
    std::string escaped;
    bool line_begins = true;
    for (const char c : text) {
        if (line_begins && (c == '.' || c == '\'')) escaped += "\\&";
        if (c == '\\')
            escaped += "\\e";
        else if (c == '-')
            escaped += "\\-";
        else
            escaped += c;
        line_begins = c == '\n';
    }
    return escaped;
}

std::string upper(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::toupper(c); });
    return text;
}

// Returns the heading "-o, --output OUT".
std::string heading_of(const OptionDescription& option) {
    std::string heading;
    for (const std::string& name : option.names)
        heading += (heading.empty() ? "\\fB" : ", \\fB") + roff(name) + "\\fR";
    if (!option.value.empty() && !option.is_positional) heading += " \\fI" + roff(option.value) + "\\fR";
    return heading;
}

// Returns the options by their groups, in the order of the groups' first options.
std::string options_of(const CommandDescription& command) {
    std::vector<std::string> groups;
    for (const OptionDescription& option : command.options)
        if (std::ranges::find(groups, option.group) == groups.end()) groups.push_back(option.group);
    std::string text;
    for (const std::string& group : groups) {
        text += ".SS " + roff(group) + "\n";
        for (const OptionDescription& option : command.options)
            if (option.group == group) text += ".TP\n" + heading_of(option) + "\n" + roff(option.help) + "\n";
    }
    return text;
}

// Returns "Examples:" and the indented lines below it as a section, other lines as paragraphs.
std::string footer_of(const CommandDescription& command) {
    std::istringstream lines(command.footer);
    std::string text;
    bool in_example = false;
    for (std::string line; std::getline(lines, line);) {
        const bool indented = line.starts_with("  ");
        if (in_example && !indented) text += ".fi\n";
        if (indented && !in_example) text += ".nf\n";
        in_example = indented;
        if (line == "Examples:" || line == "Example:")
            text += ".SH EXAMPLES\n";
        else if (!line.empty() && !line.starts_with("Exit codes:"))  // exit_status() has them
            text += (indented ? "" : ".PP\n") + roff(indented ? line.substr(2) : line) + "\n";
    }
    return text + (in_example ? ".fi\n" : "");
}

std::string exit_status() {
    std::string text = ".SH EXIT STATUS\n";
    for (const auto& [code, meaning] : kExitCodes)
        text += ".TP\n\\fB" + std::to_string(code) + "\\fR\n" + meaning + "\n";
    return text;
}

std::string commands_of(const CommandDescription& command, const std::string& full_name) {
    std::string text = command.commands.empty() ? "" : ".SH COMMANDS\n";
    for (const CommandDescription& sub : command.commands)
        text += ".TP\n\\fB" + roff(full_name + " " + sub.name) + "\\fR\n" + roff(sub.help) + "\n";
    return text;
}

// Returns the options of the commands below a command, which have no page of their own.
std::string nested_of(const CommandDescription& command) {
    std::string text;
    for (const CommandDescription& sub : command.commands)
        text += ".SH OPTIONS OF " + roff(upper(sub.name)) + "\n" + options_of(sub);
    return text;
}

std::string page_of(const CommandDescription& command, const std::string& full_name, bool is_program) {
    std::string dashed = full_name;
    std::ranges::replace(dashed, ' ', '-');
    std::string text =
        ".TH " + upper(dashed) + " 1 \"\" \"hexrelief " HEXRELIEF_VERSION "\" \"User Commands\"\n";
    text +=
        ".SH NAME\n" + roff(dashed) + " \\- " + roff(command.help) + "\n.SH SYNOPSIS\n.B " + full_name + "\n";
    for (const OptionDescription& option : command.options)
        if (option.is_positional) text += ".I " + roff(option.names.front()) + "\n";
    text += command.commands.empty() ? "[\\fIoptions\\fR]\n" : "\\fIcommand\\fR [\\fIoptions\\fR]\n";
    text += commands_of(command, full_name) + ".SH OPTIONS\n" + options_of(command);
    if (!is_program) text += nested_of(command);
    text += footer_of(command) + exit_status();
    if (!is_program) text += ".SH SEE ALSO\n.BR hexrelief (1)\n";
    return text;
}

struct ManualOptions {
    std::string command;
    std::filesystem::path folder;
};

}  // namespace

std::string manual_page(const CommandDescription& program, const std::string& command) {
    if (command.empty()) return page_of(program, program.name, true);
    for (const CommandDescription& sub : program.commands)
        if (sub.name == command) return page_of(sub, program.name + " " + sub.name, false);
    throw Error(ErrorKind::usage, "there is no command '" + command + "'; see 'hexrelief --help'");
}

void write_manual_pages(const CommandDescription& program, const std::filesystem::path& folder) {
    exporters::FileTransaction files;
    files.write(folder / (program.name + ".1"), manual_page(program, ""));
    for (const CommandDescription& sub : program.commands)
        files.write(folder / (program.name + "-" + sub.name + ".1"), manual_page(program, sub.name));
    files.commit();
}

void add_manual_command(Command& program) {
    Command command = program.add_command("manual", "the manual page of a command");
    const auto options = std::make_shared<ManualOptions>();
    command.add_option("COMMAND", &options->command, "a command; without one the program's own page");
    command.add_option("--into", &options->folder, "write the pages of all commands into this folder instead",
                       {.value = "DIR"});
    command.set_footer(R"(Example:
  hexrelief manual run | man -l -)");
    command.set_action([options, program] {
        if (options->folder.empty())
            std::fputs(manual_page(program.describe(), options->command).c_str(), stdout);
        else
            write_manual_pages(program.describe(), options->folder);
        return 0;
    });
}

}  // namespace hexrelief::cli
