// The commands for maps that do not fit into memory.
#pragma once

#include "pipeline/cli/arguments/arguments.h"

namespace hexrelief {

void add_tiles_command(Command& program);

}  // namespace hexrelief
