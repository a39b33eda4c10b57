// Scripts by which shells complete a command line.
#pragma once

#include <string>

#include "pipeline/cli/arguments/argument_parser.h"

namespace hexrelief::cli {

// Returns a script for "bash", "zsh" or "fish". Throws Error(usage) for another shell.
std::string completion_script(const CommandDescription& program, const std::string& shell);

}  // namespace hexrelief::cli
