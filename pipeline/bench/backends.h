// The backends that benchmarks run on.
#pragma once

#include <vector>

#include "pipeline/job/backend.h"

namespace hexrelief::bench {

// Returns all usable backends, the CPU first.
std::vector<job::BackendPointer> usable_backends(int threads);

}  // namespace hexrelief::bench
