// Memory that the threads of a team read and write at the same time: relaxed atomics, and sets joined by
// many.
#pragma once

#include <cstdint>

#include "pipeline/base/host_device.h"

// Marks the control flow of a team of threads, which CUDA sources compile for the device alone.
#ifdef __CUDACC__
#define HEXRELIEF_TEAM __device__ __forceinline__
#else
#define HEXRELIEF_TEAM inline
#endif

namespace hexrelief::step {

template <typename T>
HEXRELIEF_TEAM T load(const T* from) {
#ifdef __CUDACC__
    return *static_cast<const volatile T*>(from);
#else
    return __atomic_load_n(from, __ATOMIC_RELAXED);
#endif
}
template <typename T>
HEXRELIEF_TEAM void store(T* to, T value) {
#ifdef __CUDACC__
    *static_cast<volatile T*>(to) = value;
#else
    __atomic_store_n(to, value, __ATOMIC_RELAXED);
#endif
}
// Adds n and returns the number before.
HEXRELIEF_TEAM unsigned add_to(unsigned* to, unsigned n) {
#ifdef __CUDACC__
    return atomicAdd(to, n);
#else
    return __atomic_fetch_add(to, n, __ATOMIC_RELAXED);
#endif
}
// Replaces the number and returns the one before.
HEXRELIEF_TEAM unsigned exchange(unsigned* at, unsigned value) {
#ifdef __CUDACC__
    return atomicExch(at, value);
#else
    return __atomic_exchange_n(at, value, __ATOMIC_RELAXED);
#endif
}
// Replaces the number by `value` if that is lower.
HEXRELIEF_TEAM void lower_to(std::uint64_t* at, std::uint64_t value) {
#ifdef __CUDACC__
    atomicMin(reinterpret_cast<unsigned long long*>(at), static_cast<unsigned long long>(value));
#else
    for (std::uint64_t own = load(at);
         value < own &&
         !__atomic_compare_exchange_n(at, &own, value, false, __ATOMIC_RELAXED, __ATOMIC_RELAXED);) {
    }
#endif
}
// Replaces `from` by `value` if it is there; true if it was.
HEXRELIEF_TEAM bool replace(unsigned* at, unsigned from, unsigned value) {
#ifdef __CUDACC__
    return atomicCAS(at, from, value) == from;
#else
    return __atomic_compare_exchange_n(at, &from, value, false, __ATOMIC_RELAXED, __ATOMIC_RELAXED);
#endif
}

// Disjoint sets of numbered entries, which many threads join at the same time. A set's root is its lowest
// entry, so that the order of threads does not matter.
struct SharedSets {
    unsigned* parents;  // a root is its own

    HEXRELIEF_TEAM unsigned root(unsigned entry) const {
        for (unsigned parent = load(parents + entry); parent != entry;) {
            const unsigned next = load(parents + parent);
            if (next != parent) store(parents + entry, next);  // halves the path
            entry = parent;
            parent = next;
        }
        return entry;
    }
    HEXRELIEF_TEAM void join(unsigned a, unsigned b) const {
        for (;;) {
            a = root(a);
            b = root(b);
            if (a == b) return;
            const unsigned high = max_of(a, b), low = min_of(a, b);
            if (replace(parents + high, high, low)) return;
        }
    }
};

}  // namespace hexrelief::step
