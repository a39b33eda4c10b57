#include <cstdio>
#include <memory>

#include "pipeline/cli/commands.h"
#include "pipeline/cli/completions.h"

namespace hexrelief::cli {

void add_completion_command(Command& program) {
    Command command = program.add_command("completion", "what a shell offers while commands are typed");
    const auto shell = std::make_shared<std::string>();
    command.add_option("SHELL", shell.get(), "what the script is for",
                       {.value = "bash|zsh|fish", .required = true});
    command.set_footer(
        "Examples:\n"
        "  source <(hexrelief completion bash)\n"
        "  hexrelief completion fish > ~/.config/fish/completions/hexrelief.fish");
    command.set_action([shell, program] {
        std::fputs(completion_script(program.describe(), *shell).c_str(), stdout);
        return 0;
    });
}

}  // namespace hexrelief::cli
