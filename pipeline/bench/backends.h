// What the benchmarks run on.
#pragma once

#include <vector>

#include "pipeline/job/backend.h"

namespace hexrelief {

// Every backend that can be used here, the CPU first.
std::vector<BackendPointer> usable_backends(int threads);

}  // namespace hexrelief
