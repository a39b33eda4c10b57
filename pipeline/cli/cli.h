// The command line: arguments in, exit code out.
#pragma once

namespace hexrelief::cli {

// Runs the command line; prints to stdout and stderr. Never throws: an exception from a command becomes a
// message of one line and its exit code.
int run_command_line(int argc, char** argv);

}  // namespace hexrelief::cli
