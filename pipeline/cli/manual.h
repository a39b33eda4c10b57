// Makes manual pages from the help.
#pragma once

#include <filesystem>
#include <string>

#include "pipeline/cli/arguments/argument_parser.h"

namespace hexrelief::cli {

// Returns the manual page of a command, or of the program if `command` is empty, as roff, which `man -l`
// shows. Throws Error(usage) if there is no such command.
std::string manual_page(const CommandDescription& program, const std::string& command);

// Writes hexrelief.1, hexrelief-run.1, ... into an existing folder. Throws Error(output).
void write_manual_pages(const CommandDescription& program, const std::filesystem::path& folder);

}  // namespace hexrelief::cli
