// A vector that leaves new items uninitialised, so that the threads that fill it touch its memory first, and
// an allocator of many small arrays whose addresses stay valid.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

namespace hexrelief {

// An allocator whose construct() without arguments does nothing for trivially copyable types.
template <typename T>
struct RawAllocator : std::allocator<T> {
    template <typename U>
    struct rebind {
        using other = RawAllocator<U>;
    };
    template <typename U>
    void construct(U* at) {
        if constexpr (!std::is_trivially_copyable_v<U>) ::new (static_cast<void*>(at)) U;
    }
    template <typename U, typename... Arguments>
    void construct(U* at, Arguments&&... arguments) {
        ::new (static_cast<void*>(at)) U(std::forward<Arguments>(arguments)...);
    }
};

// resize() does not initialise new items of trivially copyable types.
template <typename T>
using RawVector = std::vector<T, RawAllocator<T>>;

// Allocates many small arrays whose addresses stay valid while more are allocated. Frees all arrays together
// in its destructor. For use by one thread; T must be trivially copyable.
template <typename T>
class BlockAllocator {
  public:
    // Returns an array of `count` uninitialised items.
    T* allocate(std::size_t count) {
        constexpr std::size_t kBlock = std::size_t{1} << 17;  // bytes
        if (blocks_.empty() || used_ + count > blocks_.back().size()) {
            blocks_.emplace_back(std::max(kBlock / sizeof(T), count));
            used_ = 0;
        }
        T* const items = blocks_.back().data() + used_;
        used_ += count;
        return items;
    }

  private:
    std::vector<RawVector<T>> blocks_;
    std::size_t used_ = 0;  // items used of the last block
};

}  // namespace hexrelief
