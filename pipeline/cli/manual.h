// Makes manual pages from the help.
#pragma once

#include <filesystem>
#include <string>

#include "pipeline/cli/arguments/argument_parser.h"

namespace hexrelief::cli {

// The program's exit codes with their meanings. All pages have them, and the help of `run`.
struct ExitCode {
    int code;
    const char* meaning;
};
inline constexpr ExitCode kExitCodes[] = {{0, "done"},   {1, "a bug"},        {2, "usage or configuration"},
                                          {3, "input"},  {4, "output"},       {5, "device"},
                                          {6, "memory"}, {130, "interrupted"}};

// Returns the manual page of a command, or of the program if `command` is empty, as roff, which `man -l`
// shows. Throws Error(usage) if there is no such command.
std::string manual_page(const CommandDescription& program, const std::string& command);

// Writes hexrelief.1, hexrelief-run.1, ... into an existing folder. Throws Error(output).
void write_manual_pages(const CommandDescription& program, const std::filesystem::path& folder);

}  // namespace hexrelief::cli
