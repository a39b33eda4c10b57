// The data that semi-global matching keeps for each pixel and each disparity searched there, for a band of
// rows, and the steps that set its costs and choose from their sums.
#pragma once

#include "cuda/matching/common/device_raster.h"
#include "cuda/matching/sgm/pictures.h"
#include "pipeline/matching/sgm/path_step.h"
#include "pipeline/matching/sgm/sgm.h"
#include "pipeline/matching/sgm/volume.h"
#include "pipeline/matching/sgm/window_step.h"

namespace hexrelief::cuda {

// The data that a path reads at a pixel beside its costs, in one word: the penalty of a large step to the
// pixel, and the disparities searched there. The lowest bits hold the penalty, up to the largest that 16-bit
// sums allow; the bits above hold the start of the far run and that of the near run, in steps of
// kRunAlignment.
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

// A group of lanes holds a pixel's entries, each lane a part of the far run and the same part of the near
// run, in pairs of 16 bits with the far run's entry in the lower half. So the neighbours of a pair's entries
// are another pair. Kernels are templates of a run's length.
inline constexpr int kGroup = 4;
template <int kRun>
inline constexpr int kPart = kRun / kGroup;

// The best match of a pixel of the right view: the upper half of its step::winner_key, the disparity, and the
// distance of the winner from it in 1/16 px. Better matches are smaller.
using RightBest = std::uint32_t;
inline constexpr RightBest kNoRightBest = ~RightBest{0};

// The entries of each pixel in the band's rows. Costs are stored lane by lane; of the sums, first four of
// each lane's pairs, then the others, so that the lanes together fill whole memory sectors.
struct DeviceVolume {
    int width;
    matching::DisparityRange range;
    matching::Band band;
    PathPixels pixels;  // the whole picture's
    std::uint8_t* costs;
    std::uint16_t *sums_of_rows, *sums_of_columns;  // costs of the axis' paths that end at a pixel, summed
    RightBest* right_best;                          // null: only the left view is wanted

    // Returns the index of an entry among its pixel's sums.
    template <int kRun>
    static HEXRELIEF_HD int place(int entry) {
        const int in_run = entry % kRun, lane = in_run / kPart<kRun>, k = in_run % kPart<kRun>;
        return (k / 4 * kGroup + lane) * 8 + k % 4 * 2 + entry / kRun;
    }
};

// Computes the matching costs of a band of rows. Sets the volume's costs, and clears its right_best.
void find_costs(cudaStream_t stream, const PairArrays& pair, const DeviceVolume& volume);

// Finds the best disparity of each pixel, in both views. Sets the kept rows of both views, in 1/16 px above
// the range's first disparity, from the sums of both axes.
void find_winners(cudaStream_t stream, const DeviceVolume& volume,
                  const matching::RasterView<std::int16_t>& left,
                  const matching::RasterView<std::int16_t>& right);

}  // namespace hexrelief::cuda
