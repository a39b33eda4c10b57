#include <cstdio>
#include <memory>

#include "pipeline/cli/commands.h"
#include "pipeline/cli/manual.h"

namespace hexrelief::cli {
namespace {

struct ManualOptions {
    std::string command;
    std::filesystem::path folder;
};

}  // namespace

void add_manual_command(Command& program) {
    Command command = program.add_command("manual", "the manual page of a command");
    const auto options = std::make_shared<ManualOptions>();
    command.add_option("COMMAND", &options->command, "a command; without one the program's own page");
    command.add_option("--into", &options->folder, "write the pages of all commands into this folder instead",
                       {.value = "DIR"});
    command.set_footer("Example:\n  hexrelief manual run | man -l -");
    command.set_action([options, program] {
        if (options->folder.empty())
            std::fputs(manual_page(program.describe(), options->command).c_str(), stdout);
        else
            write_manual_pages(program.describe(), options->folder);
        return 0;
    });
}

}  // namespace hexrelief::cli
