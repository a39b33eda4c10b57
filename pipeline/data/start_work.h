// Runs work in a thread beside the caller's.
#pragma once

#include <future>
#include <utility>

namespace hexrelief {

// Starts `work`, a callable without arguments, in a thread of its own. If `threads` is 1, or the system has
// no thread left, the work is done by the first call of get() instead. get() returns what the work returns
// or throws what it throws. The future's destructor waits for the work, so the work may refer to any object
// that outlives the future.
template <typename Work>
auto start_work(int threads, Work work) {
    return std::async(threads > 1 ? std::launch::async | std::launch::deferred : std::launch::deferred,
                      std::move(work));
}

}  // namespace hexrelief
