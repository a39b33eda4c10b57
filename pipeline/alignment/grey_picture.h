// Grey pictures of the size at which points are looked for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipeline/base/thread_pool.h"
#include "pipeline/data/image.h"

namespace hexrelief::alignment {

// Row-major, top row first. The centre of the first pixel is at (0, 0).
struct GreyPicture {
    int width = 0, height = 0;
    std::vector<std::uint8_t> values;

    const std::uint8_t* row(int y) const { return values.data() + static_cast<std::size_t>(y) * width; }
    std::uint8_t* row(int y) { return values.data() + static_cast<std::size_t>(y) * width; }
};

// Returns the image in grey, reduced so that its longer side has at most `longest` px. Each pixel is the mean
// over the area that it covers, in whole numbers. A side of the image has at most kLargestPairSide_px.
GreyPicture reduced_grey(const Image& image, int longest, ThreadPool& pool);

// Returns the picture at half of its size, by means of 2 x 2 px; a last odd row or column is left out.
GreyPicture halved(const GreyPicture& picture);

}  // namespace hexrelief::alignment
