// An uninitialised array of hundreds of megabytes, on large pages if the system has them: touching a new page
// of 4 KiB costs more than matching the 1,365 entries that it holds.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <type_traits>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace hexrelief::matching {

template <typename T>
class LargeArray {
    static_assert(std::is_trivially_copyable_v<T>);

  public:
    explicit LargeArray(std::size_t count) {
        constexpr std::size_t kPage = std::size_t{1} << 21;
        const std::size_t bytes = (count * sizeof(T) + kPage - 1) / kPage * kPage;
        values_.reset(static_cast<T*>(std::aligned_alloc(kPage, bytes)));
        if (!values_) throw std::bad_alloc();
#ifdef MADV_HUGEPAGE
        madvise(values_.get(), bytes, MADV_HUGEPAGE);  // a hint; nothing is lost if it is refused
#endif
    }
    T* data() {
        return values_.get();
    }
    const T* data() const {
        return values_.get();
    }

  private:
    struct Free {
        void operator()(T* values) const { std::free(values); }
    };
    std::unique_ptr<T, Free> values_;
};

}  // namespace hexrelief::matching
