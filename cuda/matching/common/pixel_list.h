// Pixels of a picture that one kernel lists for others.
#pragma once

#include <cstdint>

namespace hexrelief::cuda {

// Each word holds y in its upper half and x in its lower half; the order is arbitrary.
struct PixelList {
    std::uint32_t* pixels;  // capacity for all pixels of the picture
    std::uint32_t* count;
};

}  // namespace hexrelief::cuda
