// `hexrelief bench`: one subcommand a benchmark.
#pragma once

#include "pipeline/cli/commands.h"

namespace hexrelief {

// The group itself; it calls one register_* function for each benchmark.
void add_bench_command(CLI::App& app, Action& chosen);

}  // namespace hexrelief
