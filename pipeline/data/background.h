// Work that is done beside the caller's.
#pragma once

#include <future>
#include <utility>

namespace hexrelief {

// Starts `work`, which has no arguments, in a thread of its own; where the caller may use one thread only, or
// the system has none left, it is done when its result is asked for. get() returns what it returns or throws
// what it throws. The future waits for its work where it is destroyed, so that the work may refer to what
// lives longer than the future.
template <typename Work>
auto start_work(int threads, Work work) {
    return std::async(threads > 1 ? std::launch::async | std::launch::deferred : std::launch::deferred,
                      std::move(work));
}

}  // namespace hexrelief
