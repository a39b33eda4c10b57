// Version and origin of the program.
#pragma once

#include <string>

namespace hexrelief::cli {

// Returns "hexrelief 0.2.0"; if verbose, also lines with commit, compiler, CUDA and libraries.
std::string version_text(bool verbose);

}  // namespace hexrelief::cli
