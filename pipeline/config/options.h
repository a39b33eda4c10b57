// Command-line options that set a key, which the rows of the field table list, and the words of a command
// line.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "pipeline/config/config.h"
#include "pipeline/config/fields.h"
#include "pipeline/data/error.h"

namespace hexrelief::config {

struct Preset {
    std::string name;  // the file's name without ".yaml"
    std::string yaml;
};

const std::vector<Preset>& presets();

// Returns null if no preset has this name.
const Preset* find_preset(const std::string& name);

// Returns `base` with the values of each file, or of the preset of that name, and then of the settings
// ("key.path=value"), in their order. Call finish_config() afterwards. Throws Error(usage).
Config read_config(const std::vector<std::string>& files, const std::vector<std::string>& settings,
                   const Config& base = {});
// Returns the configuration to start from if neither preset nor file is named: the defaults; for a limit on
// bytes the preset compact; for a limit on vertices compact with the default export settings.
Config budget_base(const BudgetConfig& budget);
// Set a key from an option's text or number, checked by the field table. Throw Error(usage)
// that names the option.
void apply_option(Config& config, const std::string& option, const std::string& path,
                  const std::string& text);
void apply_option(Config& config, const std::string& option, const std::string& path, double value);
// Checks the rules between fields. Throws Error(usage).
void finish_config(const Config& config);

// Returns the flags of a group in the help, in the table's order: "Input", "Output" (keys
// of `export`), or "Job".
std::vector<std::string> option_flags(const std::string& group);

// Returns the rows that have the flag. Rows may share a flag if each needs a file of its own: --unknown is
// for the disparity map or for the depth map.
std::vector<const Field*> rows_of_option(const std::string& flag);

// Return the help of a row's option and the name of its value: "DEG", "auto|cpu|cuda"; empty = no value.
std::string option_help(const Field& field);
std::string option_value(const Field& field);

// Returns the row that an option sets in a run that reads files by the options `files`. Throws Error(usage)
// if no row has the flag, or if the file that the row needs is not among them.
const Field& row_of_option(const std::string& flag, const std::vector<std::string>& files);

// Returns the keys that the options set, in their order: a second value goes to FieldOption::second. Throws
// as row_of_option(), and Error(usage) for a third.
std::vector<std::string> keys_of_options(const std::vector<std::pair<std::string, std::string>>& options,
                                         const std::vector<std::string>& files);

// Sets the rows of the options, which are flags with their values as typed, in their order: {"--fov-x",
// "60"}; "true" for a flag without a value. Throws as row_of_option(), and Error(usage) for values out of
// range.
void apply_options(Config& config, const std::vector<std::pair<std::string, std::string>>& options,
                   const std::vector<std::string>& files);

// Returns the words between white space; "double quotes" hold spaces, and a doubled quote in
// them is one quote.
std::vector<std::string> words_of_line(const std::string& line);

// Returns the word as a POSIX shell reads it back, on one line, in single quotes if necessary. Throws
// Error(usage) for a word with a line end, which a line cannot hold.
std::string shell_quoted(const std::string& word);
std::string shell_line(const std::vector<std::string>& words);

}  // namespace hexrelief::config
