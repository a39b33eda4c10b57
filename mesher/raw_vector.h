// Vectors whose items are left as they are until threads write them, each its own.
#pragma once

#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace hexrelief {

template <typename T>
struct RawAllocator : std::allocator<T> {
    template <typename U>
    struct rebind {
        using other = RawAllocator<U>;
    };
    template <typename U>
    void construct(U* at) {
        ::new (static_cast<void*>(at)) U;
    }
    template <typename U, typename... Arguments>
    void construct(U* at, Arguments&&... arguments) {
        ::new (static_cast<void*>(at)) U(std::forward<Arguments>(arguments)...);
    }
};

// resize() leaves new items of the plain types without a value.
template <typename T>
using RawVector = std::vector<T, RawAllocator<T>>;

}  // namespace hexrelief
