// The commands `hexrelief tiles`, for maps that do not fit into memory.
#pragma once

#include "pipeline/cli/arguments/argument_parser.h"

namespace hexrelief::cli {

void add_tiles_command(Command& program);
void add_solve_command(Command& group);  // one of them

}  // namespace hexrelief::cli
