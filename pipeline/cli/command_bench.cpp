#include "pipeline/cli/command_bench.h"

#include <CLI/CLI.hpp>

#include "pipeline/bench/cuda.h"
#include "pipeline/bench/rd.h"
#include "pipeline/bench/table2.h"

namespace hexrelief {

void add_bench_command(CLI::App& app, Action& chosen) {
    CLI::App* group = app.add_subcommand("bench", "measure time and quality");
    group->require_subcommand(1);
    group->footer(
        "Examples:\n  hexrelief bench table2 --data middlebury --json table2.json\n"
        "  hexrelief bench rd --data middlebury --json rd.json\n"
        "  hexrelief bench cuda --data middlebury --json cuda.json");
    register_bench_table2(*group, chosen);
    register_bench_rd(*group, chosen);
    register_bench_cuda(*group, chosen);
}

}  // namespace hexrelief
