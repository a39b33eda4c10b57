// --config and --set, as several commands take them.
#pragma once

#include <string>

#include "pipeline/cli/arguments/argument_parser.h"
#include "pipeline/config/options.h"

namespace hexrelief::cli {

void add_config_options(Command& command, config::ConfigOptions& options, const std::string& group);

}  // namespace hexrelief::cli
