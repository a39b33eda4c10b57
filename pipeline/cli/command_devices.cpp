#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "pipeline/cli/commands.h"
#include "pipeline/job/backend.h"

namespace hexrelief::cli {

void add_devices_command(Command& program) {
    Command command = program.add_command("devices", "what --backend can use on this machine");
    const auto json = std::make_shared<bool>(false);
    command.add_flag("--json", *json, "as JSON");
    command.set_footer(R"(Example:
  hexrelief devices)");
    command.set_action([json] {
        nlohmann::ordered_json all = nlohmann::ordered_json::array();
        for (const auto& [backend, name, details, usable] : job::list_devices()) {
            all.push_back({{"backend", backend}, {"name", name}, {"details", details}, {"usable", usable}});
            if (!*json)
                std::printf("%-5s %s (%s)%s\n", backend.c_str(), name.c_str(), details.c_str(),
                            usable ? "" : " - not usable");
        }
        if (*json) std::printf("%s\n", all.dump(2).c_str());
        return 0;
    });
}

}  // namespace hexrelief::cli
