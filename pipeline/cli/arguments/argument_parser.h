// Commands, options and help of a command line, reduced to the forms that this program needs, and the options
// that several commands share.
#pragma once

#include <hexrelief/hexrelief.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "pipeline/config/options.h"

namespace CLI {
class App;
}

namespace hexrelief::cli {

// Runs a command after its options are read. Returns the exit code; throws Error.
using Action = std::function<int()>;

// The variable that receives an option's value; it must outlive the parsing.
using OptionTarget =
    std::variant<int*, std::optional<int>*, std::optional<long long>*, std::optional<double>*, std::string*,
                 std::filesystem::path*, std::vector<double>*, std::vector<std::string>*,
                 std::vector<std::filesystem::path>*>;

struct OptionTraits {
    std::string group = {};  // heading in the help; empty = "Options"
    std::string value = {};  // name of the value in the help; empty = its type
    bool required = false;
    bool repeated = false;         // a list that grows by one value each time the option is given
    bool comma_separated = false;  // a list in one word
    bool shows_default = false;
    struct Range {
        int min, max;  // inclusive
    };
    std::optional<Range> range = {};
    std::string excludes = {};  // an option, added before, that excludes this one
};

// Contents of the help, for manual pages and completions.
struct OptionDescription {
    std::vector<std::string> names;  // "-o", "--output"; the name of a positional argument
    std::string value;               // name of the value in the help; empty = a flag
    std::string help, group;
    bool is_positional = false, is_repeated = false;
};
struct CommandDescription {
    std::string name, help, footer;
    std::vector<OptionDescription> options;
    std::vector<CommandDescription> commands;
};

// A handle: all copies refer to the same command.
class Command {
  public:
    // Options appear in the help in the order of adding. Names without a leading dash are positional.
    void add_option(const std::string& name, const OptionTarget& target, const std::string& help,
                    const OptionTraits& traits = {});
    void add_flag(const std::string& name, bool& target, const std::string& help,
                  const OptionTraits& traits = {});
    // Passes the value's text to `take` after all is parsed; the text of an option without a value is "true".
    void add_option(const std::string& name, const std::function<void(const std::string&)>& take,
                    const std::string& help, const OptionTraits& traits);
    // A command that has commands below it requires one of them.
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
    // Adds --version, and --verbose for the longer text of `version`; an empty function adds neither.
    ArgumentParser(const std::string& program, const std::string& help,
                   const std::function<std::string(bool verbose)>& version);
    ~ArgumentParser();
    Command root();

    // Returns the action of the given command; none after printing the help or the version. Throws
    // Error(usage), which suggests the nearest name for a misspelt one.
    std::optional<Action> parse(int argc, char** argv);

  private:
    std::unique_ptr<CLI::App> app_;
    Action chosen_;
};

// Adds --config, --set and the options that set a key to a command.
void add_config_options(Command& command, Options& options, const std::string& group);

// Adds the field table's options with these flags; appends those that are given to `options.direct`.
void add_key_options(Command& command, Options& options, const std::vector<std::string>& flags,
                     const std::string& group);

// Selects every N-th item from item K on, for K/N.
struct Shard {
    std::size_t number = 1, of = 1;
};

// Parses "K/N" of --shard; an empty text gives 1/1. Throws Error(usage).
Shard parse_shard(const std::string& text);

// Parses the value of --memory, "8G", "512M", or bytes; an empty text gives 0. Throws Error(usage).
std::uint64_t parse_memory(const std::string& text);

}  // namespace hexrelief::cli
