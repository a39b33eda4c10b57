#include "pipeline/cli/build_info.h"

#include "hexrelief_build_info.h"  // made by pipeline/cli/build_info.cmake

namespace hexrelief::cli {

std::string version_text(bool verbose) {
    const std::string version = "hexrelief " HEXRELIEF_VERSION;
    if (!verbose) return version;
    return version + "\ncommit     " HEXRELIEF_COMMIT "\nbuild      " HEXRELIEF_BUILD
                     "\nCUDA       " HEXRELIEF_CUDA_BUILD "\nlibraries  " HEXRELIEF_LIBRARIES;
}

}  // namespace hexrelief::cli
