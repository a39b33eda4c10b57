// Adds --config, --set and the options that set a key to several commands.
#pragma once

#include <hexrelief/hexrelief.h>

#include <string>
#include <vector>

#include "pipeline/cli/arguments/argument_parser.h"
#include "pipeline/config/key_options.h"

namespace hexrelief::cli {

void add_config_options(Command& command, Options& options, const std::string& group);

// Adds the field table's options with these flags; appends those that are given to `options.direct`.
void add_key_options(Command& command, Options& options, const std::vector<std::string>& flags,
                     const std::string& group);

}  // namespace hexrelief::cli
