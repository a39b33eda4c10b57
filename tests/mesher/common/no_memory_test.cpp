// Tests that a pool of threads can be made, or refused, wherever memory runs out meanwhile.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "pipeline/base/thread_pool.h"

namespace {
thread_local int allocations_left = -1;  // none is refused while it is negative
}

void* operator new(std::size_t bytes) {
    if (allocations_left == 0) throw std::bad_alloc();
    if (allocations_left > 0) --allocations_left;
    if (void* const block = std::malloc(bytes > 0 ? bytes : 1)) return block;
    throw std::bad_alloc();
}
void operator delete(void* block) noexcept {
    std::free(block);
}
void operator delete(void* block, std::size_t) noexcept {
    std::free(block);
}

namespace hexrelief::testing_mesher {
namespace {

TEST(ThreadPool, HasFewerThreadsOrNoneWithoutMemory) {
    constexpr int kThreads = 6, kEnough = 20;
    int refused = 0, reduced = 0;
    for (int allocations = 0; allocations < kEnough; ++allocations) {
        try {
            allocations_left = allocations;
            ThreadPool pool(kThreads);
            allocations_left = -1;
            reduced += pool.size() < kThreads;
            std::atomic<int> items = 0;
            pool.parallel_for_each(100, [&](int) { ++items; });
            EXPECT_EQ(items, 100);
        } catch (const std::bad_alloc&) {
            allocations_left = -1;
            ++refused;
        }
    }
    EXPECT_GT(refused, 0);
    EXPECT_GT(reduced, 0);
    EXPECT_LT(refused + reduced, kEnough);
}

}  // namespace
}  // namespace hexrelief::testing_mesher
