// Tests what becomes of threads and output files wherever memory runs out meanwhile.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>
#include <string>
#include <vector>

#include "exporters/core/file_transaction.h"
#include "pipeline/base/thread_pool.h"
#include "pipeline/data/error.h"
#include "tests/exporters/sample_scene.h"

#if !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)  // their operator new must not be replaced

namespace {
thread_local int allocations_left = -1;  // none is refused while it is negative
}

// Not inlined: the compiler would take new and free() for a mismatch.
[[gnu::noinline]] void* operator new(std::size_t bytes) {
    if (allocations_left == 0) throw std::bad_alloc();
    if (allocations_left > 0) --allocations_left;
    if (void* const block = std::malloc(bytes > 0 ? bytes : 1)) return block;
    throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* block) noexcept {
    std::free(block);
}
[[gnu::noinline]] void operator delete(void* block, std::size_t) noexcept {
    std::free(block);
}

namespace hexrelief::exporters {
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

// Once no memory is left it stays so.
TEST(FileTransactionWithoutMemory, LeavesTheOldFilesOrTheNewOnes) {
    const std::vector<std::string> names = {
        "a_name_that_takes_memory_1.glb", "a_name_that_takes_memory_2.obj", "a_name_that_takes_memory_3.drc"};
    int committed = 0, refused = 0;
    for (int allocations = 0; allocations < 120; ++allocations) {
        const TemporaryFolder folder;
        for (const std::string& name : names) put(folder / name, "old");
        bool is_committed = false;
        {
            FileTransaction files;
            for (const std::string& name : names) files.write(folder / name, std::string("new"));
            try {
                allocations_left = allocations;
                files.commit();
                is_committed = true;
            } catch (const std::bad_alloc&) {
            } catch (const Error&) {
            }
            allocations_left = -1;
        }
        ++(is_committed ? committed : refused);
        for (const std::string& name : names)
            EXPECT_EQ(contents(folder / name), is_committed ? "new" : "old") << name << ", " << allocations;
        EXPECT_EQ(folder.entries(), 3) << allocations;
    }
    EXPECT_GT(committed, 0);
    EXPECT_GT(refused, 10);
}

}  // namespace
}  // namespace hexrelief::exporters

#endif
