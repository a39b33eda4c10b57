// The clock of all time measurements.
#pragma once

#include <chrono>

namespace hexrelief {

// Returns the time of a steady clock in seconds.
inline double now_seconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace hexrelief
