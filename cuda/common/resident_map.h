// The disparity map that the mesh stage leaves on the device for the surface stage.
#pragma once

#include <cuda_runtime_api.h>

#include <cstddef>
#include <vector>

#include "cuda/common/check.h"

namespace hexrelief::cuda {

class ResidentMap {
  public:
    ResidentMap() = default;
    ResidentMap(const ResidentMap&) = delete;
    ResidentMap& operator=(const ResidentMap&) = delete;
    ~ResidentMap() { cudaFree(data_); }

    // Returns device memory for a map of this many pixels; forgets the previous map.
    float* make_room(std::size_t pixels) {
        forget();
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
    // Records that this memory holds a copy of these values.
    void hold(const std::vector<float>& values) { source_ = values.data(); }
    void forget() { source_ = nullptr; }
    // Returns the device's copy of these values, which their address on the host identifies; null
    // if there is none.
    const float* copy_of(const std::vector<float>& values) const {
        return source_ != nullptr && source_ == values.data() && pixels_ == values.size() ? data_ : nullptr;
    }
    std::size_t bytes() const { return pixels_ * sizeof(float); }

  private:
    float* data_ = nullptr;
    const float* source_ = nullptr;
    std::size_t pixels_ = 0, capacity_ = 0;
};

}  // namespace hexrelief::cuda
