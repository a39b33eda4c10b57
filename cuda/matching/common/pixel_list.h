// Pixels of a picture that a kernel lists for others.
#pragma once

#include <cstdint>

namespace hexrelief::cuda {

// y in the upper halves of words, x in the lower ones, in any order.
struct PixelList {
    std::uint32_t* pixels;  // room for all of the picture's
    std::uint32_t* count;
};

}  // namespace hexrelief::cuda
