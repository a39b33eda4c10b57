#include "pipeline/cli/arguments/argument_parser.h"

#include <CLI/CLI.hpp>  // takes ten seconds to compile, so only this file includes it
#include <algorithm>
#include <charconv>
#include <cmath>

#include "pipeline/config/fields.h"
#include "pipeline/data/error.h"
#include "pipeline/data/number_text.h"

namespace hexrelief::cli {
namespace {

void apply_traits(const CLI::App& app, CLI::Option& option, const OptionTraits& traits) {
    if (!traits.group.empty()) option.group(traits.group);
    if (!traits.value.empty()) option.type_name(traits.value);
    if (traits.required) option.required();
    if (traits.repeated) option.expected(1)->take_all();
    if (traits.comma_separated) option.delimiter(',');
    if (traits.shows_default) option.capture_default_str();
    if (traits.range) option.check(CLI::Range(traits.range->min, traits.range->max));
    if (!traits.excludes.empty()) option.excludes(const_cast<CLI::Option*>(app.get_option(traits.excludes)));
}

// Returns the innermost command that was given, and stores its full name.
const CLI::App& innermost(const CLI::App& app, std::string& name) {
    name += (name.empty() ? "" : " ") + app.get_name();
    for (const CLI::App* sub : app.get_subcommands()) return innermost(*sub, name);
    return app;
}

// Returns " (did you mean '--left'?)" for the first argument that matches no option or command.
std::string suggest_argument(const CLI::App& app, int argc, char** argv) {
    std::vector<std::string> names;
    for (const CLI::Option* option : app.get_options())
        for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; }))
        names.push_back(sub->get_name());
    for (int i = 1; i < argc; ++i) {
        std::string argument = argv[i];
        argument.resize(std::min(argument.size(), argument.find('=')));
        if (std::ranges::find(names, argument) != names.end()) continue;
        const bool option = argument.starts_with("--");
        if (!option && i + 1 < argc) continue;  // probably a value
        const std::string near = config::nearest_name(argument, names);
        if (!near.empty() && near.starts_with("--") == option) return " (did you mean '" + near + "'?)";
    }
    return {};
}

OptionDescription describe_option(const CLI::Option& option) {
    OptionDescription described;
    for (const std::string& name : option.get_snames()) described.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) described.names.push_back("--" + name);
    described.is_positional = option.get_positional();
    if (described.is_positional) described.names = {option.get_name(true)};
    if (option.get_expected_max() > 0) described.value = option.get_type_name();
    described.help = option.get_description();
    described.group = option.get_group();
    described.is_repeated = option.get_multi_option_policy() == CLI::MultiOptionPolicy::TakeAll;
    return described;
}

CommandDescription describe_command(const CLI::App& app) {
    CommandDescription described{app.get_name(), app.get_description(), app.get_footer(), {}, {}};
    for (const CLI::Option* option : app.get_options()) described.options.push_back(describe_option(*option));
    for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; }))
        described.commands.push_back(describe_command(*sub));
    return described;
}

void add_setting(Options& options, const std::string& setting) {
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos)
        throw Error(ErrorKind::usage, "--set " + setting + ": write it as key.path=value");
    options.settings.emplace_back(setting.substr(0, equals), setting.substr(equals + 1));
}

}  // namespace

void Command::add_option(const std::string& name, const OptionTarget& target, const std::string& help,
                         const OptionTraits& traits) {
    CLI::Option* const option =
        std::visit([&](auto* value) { return app_->add_option(name, *value, help); }, target);
    apply_traits(*app_, *option, traits);
}

void Command::add_flag(const std::string& name, bool& target, const std::string& help,
                       const OptionTraits& traits) {
    apply_traits(*app_, *app_->add_flag(name, target, help), traits);
}

void Command::add_option(const std::string& name, const std::function<void(const std::string&)>& take,
                         const std::string& help, const OptionTraits& traits) {
    const auto take_all = [take](const std::vector<std::string>& texts) {
        for (const std::string& text : texts) take(text);
    };
    CLI::Option* const option =
        traits.value.empty() ? app_->add_flag_callback(
                                   name, [take] { take("true"); }, help)
        : traits.repeated ? app_->add_option_function<std::vector<std::string>>(name, take_all, help)
                          : app_->add_option_function<std::string>(name, take, help);
    apply_traits(*app_, *option, traits);
}

Command Command::add_command(const std::string& name, const std::string& help) {
    app_->require_subcommand(1);
    return {*app_->add_subcommand(name, help), *chosen_};
}

void Command::set_footer(const std::string& text) {
    app_->footer(text);
}

void Command::set_action(Action action) {
    app_->callback([chosen = chosen_, action = std::move(action)] { *chosen = action; });
}

CommandDescription Command::describe() const {
    return describe_command(*app_);
}

ArgumentParser::ArgumentParser(const std::string& program, const std::string& help,
                               const std::function<std::string(bool verbose)>& version)
    : app_(std::make_unique<CLI::App>(help, program)) {
    if (!version) return;
    const CLI::Option* const verbose =
        app_->add_flag("--verbose")
            ->description("with --version: commit, compiler, CUDA architectures, libraries");
    app_->set_version_flag(
        "--version", [verbose, version] { return version(verbose->count() > 0); },
        "print the version and exit");
}

ArgumentParser::~ArgumentParser() = default;

Command ArgumentParser::root() {
    return {*app_, chosen_};
}

std::optional<Action> ArgumentParser::parse(int argc, char** argv) {
    try {
        app_->parse(argc, argv);
        return chosen_;
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == 0) {  // --help, --version
            app_->exit(error);
            return std::nullopt;
        }
        std::string name;
        const CLI::App& command = innermost(*app_, name);
        std::string message = error.what();
        if (dynamic_cast<const CLI::ExtrasError*>(&error) || dynamic_cast<const CLI::RequiredError*>(&error))
            message += suggest_argument(command, argc, argv);
        throw Error(ErrorKind::usage, message + "; see '" + name + " --help'");
    }
}

void add_config_options(Command& command, Options& options, const std::string& group) {
    command.add_option("--config", &options.config,
                       "YAML file, see 'hexrelief config show', or a preset: " +
                           joined(config::presets(), ", ", &config::Preset::name) +
                           "; may be given several times, later ones win",
                       {.group = group, .value = "F.yaml", .repeated = true});
    command.add_option("--set", [&options](const std::string& setting) { add_setting(options, setting); },
                       "override one key, as in --set mesh.spacing_px=4; may be given several times",
                       {.group = group, .value = "key.path=value", .repeated = true});
}

void add_key_options(Command& command, Options& options, const std::vector<std::string>& flags,
                     const std::string& group) {
    for (const std::string& flag : flags) {
        const config::Field& row = *config::rows_of_option(flag).at(0);
        command.add_option(
            flag, [&options, flag](const std::string& text) { options.direct.emplace_back(flag, text); },
            option_help(row),
            {.group = group, .value = option_value(row), .repeated = !row.option.second.empty()});
    }
}

Shard parse_shard(const std::string& text) {
    if (text.empty()) return {};
    const std::size_t slash = std::min(text.find('/'), text.size() - 1);
    const auto number = whole_number(text.substr(0, slash)), of = whole_number(text.substr(slash + 1));
    if (!number || !of || *number < 1 || *number > *of)
        throw Error(ErrorKind::usage, "--shard: must be K/N with K from 1 to N, not '" + text + "'");
    return {*number, *of};
}

std::uint64_t parse_memory(const std::string& text) {
    if (text.empty()) return 0;
    double value = 0;
    const char* const end = text.data() + text.size();
    const auto [rest, failure] = std::from_chars(text.data(), end, value);
    const std::size_t power = rest == end ? 0 : std::string("BKMGT").find(*rest);
    const bool is_size = failure == std::errc() && end - rest <= 1 && power != std::string::npos;
    const double bytes = is_size ? std::ldexp(value, static_cast<int>(10 * power)) : 0;
    if (!(bytes >= 1 && bytes < 1e18))
        throw Error(ErrorKind::usage, "--memory: must be like 8G or 512M, not '" + text + "'");
    return static_cast<std::uint64_t>(bytes);
}

}  // namespace hexrelief::cli
