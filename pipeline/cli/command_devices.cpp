#include <cstdio>

#include "pipeline/cli/commands.h"
#include "pipeline/job/backend.h"

namespace hexrelief::cli {

void add_devices_command(Command& program) {
    Command command = program.add_command("devices", "what --backend can use on this machine");
    command.set_footer("Example:\n  hexrelief devices");
    command.set_action([] {
        for (const job::DeviceDescription& device : job::list_devices())
            std::printf("%-5s %s (%s)%s\n", device.backend.c_str(), device.name.c_str(),
                        device.details.c_str(), device.usable ? "" : " - not usable");
        return 0;
    });
}

}  // namespace hexrelief::cli
