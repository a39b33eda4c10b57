// Keeps meshes off terminals.
#pragma once

#include <string>
#include <vector>

namespace hexrelief::cli {

// Throws Error(usage) if one of the outputs is the standard output, and that is a terminal.
void refuse_terminal(const std::vector<std::string>& outputs);

}  // namespace hexrelief::cli
