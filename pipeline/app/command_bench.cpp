#include "pipeline/app/command_bench.h"

#include <CLI/CLI.hpp>

namespace hexrelief {

void add_bench_command(CLI::App& app, Action& chosen) {
    static_cast<void>(chosen);
    static_cast<void>(app);
}

}  // namespace hexrelief
