// The backends that benchmarks run on.
#pragma once

#include <vector>

#include "pipeline/job/backend.h"

namespace hexrelief::bench {

// Returns every usable backend, the CPU first.
std::vector<job::Backend> usable_backends(int threads);

}  // namespace hexrelief::bench
