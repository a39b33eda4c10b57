// Loops over the rows of a raster, on all threads. They are not in raster.h because CUDA's sources do not
// need the threads' headers, which nvcc would read three times per source.
#pragma once

#include <cstddef>

#include "pipeline/base/thread_pool.h"

namespace hexrelief::matching {

// The number of pixels of a row that steps with many sums process at a time, so that the sums stay
// in the first-level cache.
inline constexpr int kBlock = 256;

// Runs body(y) for every row, on all threads.
template <typename Body>
void for_each_row(ThreadPool& pool, int height, const Body& body) {
    ThreadPool::ChunkCounters counters(pool.size());
    pool.run([&](int thread) {
        pool.run_chunks<8>(static_cast<std::size_t>(height), thread, counters,
                           [&](std::size_t first, std::size_t end) {
                               for (std::size_t y = first; y < end; ++y) body(static_cast<int>(y));
                           });
    });
}

}  // namespace hexrelief::matching
