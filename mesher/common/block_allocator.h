// Allocates many small arrays, which stay where they are while more are added.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "mesher/common/uninitialized_vector.h"

namespace hexrelief {

// Frees all arrays at once, when it goes. For one thread; T is trivially copyable.
template <typename T>
class BlockAllocator {
  public:
    // An array of `count` items without a value.
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
    std::size_t used_ = 0;  // of the last one
};

}  // namespace hexrelief
