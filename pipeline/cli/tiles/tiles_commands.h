// The commands below `hexrelief tiles`.
#pragma once

#include "pipeline/cli/arguments/argument_parser.h"

namespace hexrelief::cli {

void add_match_command(Command& group);
void add_plan_command(Command& group);
void add_solve_command(Command& group);
void add_merge_command(Command& group);

}  // namespace hexrelief::cli
