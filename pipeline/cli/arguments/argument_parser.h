// Commands, options and help of a command line, in the few forms that this program needs.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace CLI {
class App;
}

namespace hexrelief::cli {

// What a command does once its options are read. Returns the exit code; throws Error.
using Action = std::function<int()>;

// Where the value of an option goes; it must outlive the parsing.
using OptionTarget =
    std::variant<int*, std::optional<int>*, std::optional<long long>*, std::optional<double>*, std::string*,
                 std::filesystem::path*, std::vector<double>*, std::vector<std::string>*,
                 std::vector<std::filesystem::path>*>;

struct OptionTraits {
    std::string group = {};  // the heading in the help; empty = "Options"
    std::string value = {};  // what the help calls the value; empty = its type
    bool required = false;
    bool repeated = false;         // a list that grows by one value each time the option is given
    bool comma_separated = false;  // a list in one word
    bool shows_default = false;
    struct Range {
        int min, max;  // inclusive
    };
    std::optional<Range> range = {};
    std::string excludes = {};  // an option that was added before and may not be given together with this one
};

// What the help says, for manual pages and completions.
struct OptionDescription {
    std::vector<std::string> names;  // "-o", "--output"; of a positional argument its name
    std::string value;               // what the help calls the value; empty = a flag
    std::string help, group;
    bool is_positional = false, is_repeated = false;
};
struct CommandDescription {
    std::string name, help, footer;
    std::vector<OptionDescription> options;
    std::vector<CommandDescription> commands;
};

// A handle: copies speak of the same command.
class Command {
  public:
    // The order of adding is the order in the help. Names that start without a dash are positional.
    void add_option(const std::string& name, const OptionTarget& target, const std::string& help,
                    const OptionTraits& traits = {});
    void add_flag(const std::string& name, bool& target, const std::string& help,
                  const OptionTraits& traits = {});
    // The value's text goes to `take` once all is parsed; that of an option without a value is "true".
    void add_option(const std::string& name, const std::function<void(const std::string&)>& take,
                    const std::string& help, const OptionTraits& traits);
    // Where a command has commands below it, one of them must be given.
    Command add_command(const std::string& name, const std::string& help);
    void set_footer(const std::string& text);
    void set_action(Action action);
    CommandDescription describe() const;

  private:
    friend class ArgumentParser;
    Command(CLI::App& app, Action& chosen) : app_(&app), chosen_(&chosen) {}
    CLI::App* app_;
    Action* chosen_;
};

class ArgumentParser {
  public:
    // The version is asked for with --verbose or without; an empty function adds neither option.
    ArgumentParser(const std::string& program, const std::string& help,
                   const std::function<std::string(bool verbose)>& version);
    ~ArgumentParser();
    Command root();

    // The action of the command that was given, or none where the help or the version was asked for and is
    // now printed. Throws Error(usage), with the nearest name where one was misspelt.
    std::optional<Action> parse(int argc, char** argv);

  private:
    std::unique_ptr<CLI::App> app_;
    Action chosen_;
};

}  // namespace hexrelief::cli
