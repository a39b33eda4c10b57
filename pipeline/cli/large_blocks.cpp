// The program's own operator new: large blocks lie in huge pages, which Linux hands out 512 times fewer than
// its small ones. Most distributions give them to programs that ask only.
#include <sys/mman.h>

#include <cstdlib>
#include <new>

namespace {

constexpr std::size_t kHugePage = 2 << 20;

void* allocate(std::size_t bytes) {
    if (bytes < 2 * kHugePage) return std::malloc(bytes > 0 ? bytes : 1);
    void* const block = std::aligned_alloc(kHugePage, bytes);
    // Whether it is heeded makes no difference but time.
    if (block) static_cast<void>(::madvise(block, bytes, MADV_HUGEPAGE));
    return block;
}

}  // namespace

void* operator new(std::size_t bytes) {
    for (;;) {
        if (void* const block = allocate(bytes)) return block;
        const std::new_handler handler = std::get_new_handler();
        if (!handler) throw std::bad_alloc();
        handler();
    }
}

void operator delete(void* block) noexcept {
    std::free(block);
}

void operator delete(void* block, std::size_t) noexcept {
    std::free(block);
}
