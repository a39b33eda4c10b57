// Options of the command line that set a key. The rows of the field table say which there are.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "pipeline/config/fields.h"

namespace hexrelief::config {

// Flags with their values as they were typed: {"--fov-x", "60"}; "true" of a flag without a value.
using KeyOptions = std::vector<std::pair<std::string, std::string>>;

// The flags of a group in the help, in the table's order: "Input", "Output" (of `export`), or "Job".
std::vector<std::string> option_flags(const std::string& group);

// The rows that have the flag. Rows may share one if each goes with a file of its own: --unknown is that of
// the disparity map or of the depth map.
std::vector<const Field*> rows_of_option(const std::string& flag);

// What the help of a row's option says, and what it calls the value: "DEG", "auto|cpu|cuda"; empty = it has
// none.
std::string option_help(const Field& field);
std::string option_value(const Field& field);

// The row that an option sets, of a run that reads files by these options. Throws Error(usage) if no row has
// the flag, or if the file that it goes with is not among them.
const Field& row_of_option(const std::string& flag, const std::vector<std::string>& files);

// Sets the rows of the options in their order. Throws as row_of_option(), and for values out of range.
void apply_options(Config& config, const KeyOptions& options, const std::vector<std::string>& files);

}  // namespace hexrelief::config
