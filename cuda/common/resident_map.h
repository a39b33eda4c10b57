// The disparity map that the mesh stage leaves on the device for the surface stage.
#pragma once

#include <cuda_runtime_api.h>

#include <cstddef>
#include <cstdint>

#include "cuda/common/check.h"

namespace hexrelief::cuda {

class ResidentMap {
  public:
    ResidentMap() = default;
    ResidentMap(const ResidentMap&) = delete;
    ResidentMap& operator=(const ResidentMap&) = delete;
    ~ResidentMap() { cudaFree(data_); }

    // Returns memory for another map, which replaces the preceding one.
    float* replace(std::size_t pixels) {
        ++id_;
        pixels_ = pixels;
        if (pixels > capacity_) {
            cudaFree(data_);
            data_ = nullptr;
            capacity_ = 0;
            data_ = static_cast<float*>(allocate(pixels * sizeof(float)));
            capacity_ = pixels;
        }
        return data_;
    }
    // Returns the id of the latest map: never 0, and different for each map.
    std::uint64_t id() const { return id_; }
    // Returns the map with this id, or null if it has been replaced since.
    const float* find(std::uint64_t id, std::size_t pixels) const {
        return id != 0 && id == id_ && pixels == pixels_ ? data_ : nullptr;
    }
    std::size_t bytes() const { return pixels_ * sizeof(float); }

  private:
    float* data_ = nullptr;
    std::size_t pixels_ = 0, capacity_ = 0;
    std::uint64_t id_ = 0;
};

}  // namespace hexrelief::cuda
