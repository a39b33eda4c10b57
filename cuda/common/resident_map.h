// The disparity map that the mesh stage leaves on the device for the mesh.
#pragma once

#include <cuda_runtime_api.h>

#include <cstddef>
#include <cstdint>

#include "cuda/common/check.h"

namespace hexrelief::cuda {

class KeptMap {
  public:
    KeptMap() = default;
    KeptMap(const KeptMap&) = delete;
    KeptMap& operator=(const KeptMap&) = delete;
    ~KeptMap() { cudaFree(data_); }

    // Room for another map; the one before is forgotten.
    float* take(std::size_t pixels) {
        ++name_;
        pixels_ = pixels;
        if (pixels > room_) {
            cudaFree(data_);
            data_ = nullptr;
            room_ = 0;
            data_ = static_cast<float*>(allocate(pixels * sizeof(float)));
            room_ = pixels;
        }
        return data_;
    }
    // Of the map taken last; never 0, and never again another's.
    std::uint64_t name() const { return name_; }
    // nullptr where another map was taken since.
    const float* find(std::uint64_t name, std::size_t pixels) const {
        return name != 0 && name == name_ && pixels == pixels_ ? data_ : nullptr;
    }
    std::size_t bytes() const { return pixels_ * sizeof(float); }

  private:
    float* data_ = nullptr;
    std::size_t pixels_ = 0, room_ = 0;
    std::uint64_t name_ = 0;
};

}  // namespace hexrelief::cuda
