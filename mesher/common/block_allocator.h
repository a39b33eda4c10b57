// Room for many small arrays that stay where they are while more are added.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "mesher/common/uninitialized_vector.h"

namespace hexrelief {

// One thread's. T is trivially copyable.
template <typename T>
class Blocks {
  public:
    // For `count` items, without a value.
    T* room_for(std::size_t count) {
        constexpr std::size_t kBlock = std::size_t{1} << 17;  // bytes
        if (blocks_.empty() || used_ + count > blocks_.back().size()) {
            blocks_.emplace_back(std::max(kBlock / sizeof(T), count));
            used_ = 0;
        }
        T* const room = blocks_.back().data() + used_;
        used_ += count;
        return room;
    }

  private:
    std::vector<RawVector<T>> blocks_;
    std::size_t used_ = 0;  // of the last one
};

}  // namespace hexrelief
