// Add the commands, with their options, help and actions, to the parser.
#pragma once

#include "pipeline/cli/arguments/argument_parser.h"

namespace hexrelief::cli {

void add_run_command(Command& program);
void add_batch_command(Command& program);
void add_config_command(Command& program);
void add_gallery_command(Command& program);
void add_info_command(Command& program);
void add_evaluate_command(Command& program);
void add_devices_command(Command& program);
void add_tiles_command(Command& program);
void add_solve_command(Command& tiles);
void add_demo_command(Command& program);
// These two describe all commands, also those that are added later.
void add_manual_command(Command& program);
void add_completion_command(Command& program);

}  // namespace hexrelief::cli
