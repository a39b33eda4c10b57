// Each command: its options and help go into the parser, its work becomes the command's action.
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
void add_bench_command(Command& program);
void add_demo_command(Command& program);
// These two tell of the commands that were added before and after them.
void add_manual_command(Command& program);
void add_completion_command(Command& program);

}  // namespace hexrelief::cli
