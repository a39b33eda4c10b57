// Device memory of one run: a few large allocations, from which arrays are taken and
// then given back together.
#pragma once

#include <cuda_runtime_api.h>

#include <algorithm>
#include <cstddef>
#include <vector>

#include "cuda/common/check.h"

namespace hexrelief::cuda {

// Arrays are cut from slabs that are kept from run to run, because each cudaMalloc takes some 0.1 ms, a tenth
// of a small map's training. Arrays are 256-byte aligned and uninitialised.
class Arena {
  public:
    Arena() = default;
    Arena(const Arena&) = delete;
    Arena& operator=(const Arena&) = delete;
    ~Arena() {
        for (const Slab& slab : slabs_) cudaFree(slab.data);
    }

    template <typename T>
    T* take(std::size_t count) {
        const std::size_t bytes = std::max<std::size_t>(256, (count * sizeof(T) + 255) / 256 * 256);
        used_ += bytes;
        peak_ = std::max(peak_, used_);
        for (Slab& slab : slabs_)
            if (slab.bytes - slab.used >= bytes) return static_cast<T*>(cut(slab, bytes));
        const std::size_t slab_bytes = std::max(bytes, kSlabBytes);
        slabs_.push_back({allocate(slab_bytes), slab_bytes, 0});
        return static_cast<T*>(cut(slabs_.back(), bytes));
    }
    // Gives back all arrays.
    void reset() {
        for (Slab& slab : slabs_) slab.used = 0;
        used_ = peak_ = 0;
    }
    // release() gives back the arrays taken since mark(). Later work in the same stream may use their memory
    // at once, because it runs after the work that used it before.
    using Mark = std::vector<std::size_t>;
    Mark mark() const {
        Mark used;
        for (const Slab& slab : slabs_) used.push_back(slab.used);
        return used;
    }
    void release(const Mark& mark) {
        used_ = 0;
        for (std::size_t i = 0; i < slabs_.size(); ++i)
            used_ += slabs_[i].used = i < mark.size() ? mark[i] : 0;
    }
    // Returns the largest amount taken at a time since the last reset, in bytes.
    std::size_t peak_bytes() const { return peak_; }

  private:
    struct Slab {
        void* data;
        std::size_t bytes, used;
    };
    static constexpr std::size_t kSlabBytes = std::size_t{32} << 20;

    static void* cut(Slab& slab, std::size_t bytes) {
        void* const data = static_cast<char*>(slab.data) + slab.used;
        slab.used += bytes;
        return data;
    }

    std::vector<Slab> slabs_;
    std::size_t used_ = 0, peak_ = 0;
};

}  // namespace hexrelief::cuda
