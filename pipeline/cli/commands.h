// Each command: its options and help go into the parser, its work into `chosen` once the parser has met it.
#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace hexrelief {

// Returns the exit code; throws Error.
using Action = std::function<int()>;

void add_run_command(CLI::App& app, Action& chosen);
void add_config_command(CLI::App& app, Action& chosen);
void add_info_command(CLI::App& app, Action& chosen);
void add_evaluate_command(CLI::App& app, Action& chosen);
void add_devices_command(CLI::App& app, Action& chosen);

}  // namespace hexrelief
