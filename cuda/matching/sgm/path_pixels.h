// What a path reads of a pixel beside its costs, in one word: the penalty of a large step to it, and which
// disparities are searched there.
#pragma once

#include "cuda/matching/common/device_raster.h"
#include "pipeline/matching/sgm/path_step.h"
#include "pipeline/matching/sgm/volume.h"
#include "pipeline/matching/sgm/window_step.h"

namespace hexrelief::cuda {

// Runs begin where a part of so many disparities does.
inline constexpr int kPart = step::kRunAlignment;
inline constexpr int kMostDisparities = 2048;  // so that eight bits number parts

// The penalty in the lower half; above it the first part of the far run, and that of the near one.
using PathPixel = std::uint32_t;
HEXRELIEF_HD PathPixel path_pixel(std::uint16_t penalty, const SearchWindow& window) {
    return penalty | static_cast<std::uint32_t>(window.far_run / kPart) << 16 |
           static_cast<std::uint32_t>(window.near_run / kPart) << 24;
}
HEXRELIEF_HD int far_part(PathPixel pixel) {
    return static_cast<int>(pixel >> 16 & 0xffu);
}
HEXRELIEF_HD int near_part(PathPixel pixel) {
    return static_cast<int>(pixel >> 24);
}
HEXRELIEF_HD SearchWindow window_of(PathPixel pixel) {
    return {static_cast<std::int16_t>(kPart * far_part(pixel)),
            static_cast<std::int16_t>(kPart * near_part(pixel))};
}

// Of a picture, for paths along its rows and along its columns; they differ in the penalties, which are those
// of steps from the left and from above. Behind the last pixel there is a row of zeros, which paths read.
struct PathPixels {
    int width;
    PathPixel *along_rows, *along_columns;

    HEXRELIEF_HD const PathPixel* row(int y) const {
        return along_rows + static_cast<std::ptrdiff_t>(y) * width;
    }
};
PathPixels take_path_pixels(cudaStream_t stream, Arena& arena, int width, int height);

// half: the left view's winners at half size (see step::find_window()); not read where kSearched disparities
// are all that there are.
void find_path_pixels(cudaStream_t stream, const PackedColors& left, const RasterView<std::int16_t>& half,
                      const DisparityRange& range, const step::PathPenalties& penalties,
                      const PathPixels& pixels);

}  // namespace hexrelief::cuda
