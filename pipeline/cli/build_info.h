// What the program is made of.
#pragma once

#include <string>

namespace hexrelief::cli {

// "hexrelief 0.1.0"; where it is to be verbose, also lines with commit, compiler, CUDA and libraries.
std::string version_text(bool verbose);

}  // namespace hexrelief::cli
