// The backends that benchmarks run on.
#pragma once

#include <vector>

#include "pipeline/job/backend.h"

namespace hexrelief {

// Returns every usable backend, the CPU first.
std::vector<Backend> usable_backends(int threads);

}  // namespace hexrelief
