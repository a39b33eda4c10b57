// A vector that leaves new items uninitialised, so that the threads that fill it touch its memory first.
#pragma once

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

}  // namespace hexrelief
