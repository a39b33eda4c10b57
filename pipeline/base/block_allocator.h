// Allocates many small arrays whose addresses stay valid while more are allocated.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "pipeline/base/uninitialized_vector.h"

namespace hexrelief {

// Frees all arrays together in its destructor. For use by one thread; T must be trivially copyable.
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
