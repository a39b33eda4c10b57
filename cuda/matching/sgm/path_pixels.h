// The data that a path reads at a pixel beside its costs, in one word: the penalty of a large step to the
// pixel, and the disparities searched there.
#pragma once

#include "cuda/matching/common/device_raster.h"
#include "pipeline/matching/sgm/path_step.h"
#include "pipeline/matching/sgm/volume.h"
#include "pipeline/matching/sgm/window_step.h"

namespace hexrelief::cuda {

// The lowest bits hold the penalty, up to the largest that 16-bit sums allow; the bits above hold the start
// of the far run and that of the near run, in steps of kRunAlignment.
using PathPixel = std::uint32_t;
inline constexpr int kPenaltyBits = 14, kRunBits = 9;
inline constexpr std::uint32_t kPenalty = (1u << kPenaltyBits) - 1;
inline constexpr int kMostDisparities = step::kRunAlignment << kRunBits;
HEXRELIEF_HD PathPixel path_pixel(std::uint16_t penalty, const matching::SearchWindow& window) {
    const auto steps = [](int first) { return static_cast<std::uint32_t>(first / step::kRunAlignment); };
    return penalty | steps(window.far_run) << kPenaltyBits |
           steps(window.near_run) << (kPenaltyBits + kRunBits);
}
HEXRELIEF_HD int far_run(PathPixel pixel) {
    return static_cast<int>(pixel >> kPenaltyBits & ((1u << kRunBits) - 1)) * step::kRunAlignment;
}
HEXRELIEF_HD int near_run(PathPixel pixel) {
    return static_cast<int>(pixel >> (kPenaltyBits + kRunBits)) * step::kRunAlignment;
}
HEXRELIEF_HD matching::SearchWindow window_of(PathPixel pixel) {
    return {static_cast<std::int16_t>(far_run(pixel)), static_cast<std::int16_t>(near_run(pixel))};
}

// The words of a picture, for paths along its rows and along its columns. They differ in the
// penalties, which are those of steps from the left or from above. Behind the last pixel there is a
// row of zeros, which paths read.
struct PathPixels {
    int width;
    PathPixel *along_rows, *along_columns;

    HEXRELIEF_HD const PathPixel* row(int y) const {
        return along_rows + static_cast<std::ptrdiff_t>(y) * width;
    }
};
PathPixels take_path_pixels(Arena& arena, int width, int height);

// Finds the words of a picture. half: the left view's winners at half size (see step::find_window()); not
// read if the whole range is searched.
void find_path_pixels(cudaStream_t stream, const PackedColors& left,
                      const matching::RasterView<std::int16_t>& half, const matching::DisparityRange& range,
                      const step::PathPenalties& penalties, const PathPixels& pixels);

}  // namespace hexrelief::cuda
