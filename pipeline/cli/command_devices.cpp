#include <CLI/CLI.hpp>
#include <cstdio>

#include "pipeline/job/backend.h"
#include "pipeline/cli/commands.h"

namespace hexrelief {

void add_devices_command(CLI::App& app, Action& chosen) {
    CLI::App* command = app.add_subcommand("devices", "what --backend can use on this machine");
    command->footer("Example:\n  hexrelief devices");
    command->callback([&chosen] {
        chosen = [] {
            for (const DeviceDescription& device : list_devices())
                std::printf("%-5s %s (%s)%s\n", device.backend.c_str(), device.name.c_str(),
                            device.details.c_str(), device.usable ? "" : " - not usable");
            return 0;
        };
    });
}

}  // namespace hexrelief
