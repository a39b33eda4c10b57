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

    // Device memory for a map of so many pixels; the map before is forgotten.
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
    // The room now holds a copy of these values.
    void hold(const std::vector<float>& values) { source_ = values.data(); }
    void forget() { source_ = nullptr; }
    // nullptr if the device holds no copy of these values, told by where they are on the host.
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
