// Device memory of one run: a few large allocations, from which arrays are taken and given back together.
#pragma once

#include <cuda_runtime_api.h>

#include <algorithm>
#include <cstddef>
#include <vector>

#include "cuda/common/check.h"

namespace hexrelief::cuda {

// cudaMalloc costs some 0.1 ms a call, as much as a tenth of a small map's training; so arrays are cut from
// slabs that live on from run to run. They are 256-byte aligned and uninitialised.
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
    // Everything taken is free again.
    void reset() {
        for (Slab& slab : slabs_) slab.used = 0;
        used_ = peak_ = 0;
    }
    // What is taken after mark() is free again after release(). Later work of the same stream may use it at
    // once: it comes after the work that used it before.
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
    // The most that was taken at a time since the last reset.
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
