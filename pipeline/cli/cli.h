// The command line: arguments in, exit code out.
#pragma once

namespace hexrelief::cli {

// Prints to stdout and stderr. Never throws: what escapes the commands becomes one line and exit code 1.
int run_command_line(int argc, char** argv);

}  // namespace hexrelief::cli
