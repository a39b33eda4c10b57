// Manual pages, from the help.
#pragma once

#include <filesystem>
#include <string>

#include "pipeline/cli/arguments/argument_parser.h"

namespace hexrelief::cli {

// The page of a command below the program, or of the program where `command` is empty, as roff: what `man -l`
// shows. Throws Error(usage) where there is no such command.
std::string manual_page(const CommandDescription& program, const std::string& command);

// hexrelief.1, hexrelief-run.1, ... in a folder that exists. Throws Error(output).
void write_manual_pages(const CommandDescription& program, const std::filesystem::path& folder);

}  // namespace hexrelief::cli
