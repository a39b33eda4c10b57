// Time as stages and benchmarks measure it.
#pragma once

#include <chrono>

namespace hexrelief {

// Seconds on a steady clock.
inline double now_seconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace hexrelief
