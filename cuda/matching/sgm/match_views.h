// Semi-global matching on the device: both views' winners.
#pragma once

#include <cstddef>

#include "cuda/matching/common/stage_clock.h"
#include "cuda/matching/sgm/costs.h"
#include "cuda/matching/sgm/pictures.h"
#include "cuda/matching/sgm/volume.h"
#include "cuda/matching/sgm/winners.h"
#include "pipeline/matching/sgm/volume.h"

namespace hexrelief::cuda {

// The costs of paths in one direction, where the other direction begins again (see paths.h).
struct PathArrays {
    std::uint16_t *before_rows, *before_columns;  // each segment's, of all rows matched
    std::uint16_t* below;                         // of the row walked last on the way up
};

struct MatchingArrays {
    PairArrays pair;
    DeviceVolume volume;  // of as many rows as are matched at once
    int sum_rows;         // of these, how many have sums at a time
    PathArrays paths;
    WinnerKeys keys;
    int kept_rows;  // of a band
    int min_px, p1;
    bool one_band() const { return kept_rows == pair.height; }
};

// Without sums and paths, which take_sums() takes, and without what costs alone need (take_cost_arrays()).
// range.count: 1..kMostDisparities.
MatchingArrays take_matching_arrays(cudaStream_t stream, Arena& arena, const DeviceColors& colors,
                                    int channels, const DisparityRange& range, int p1);
void take_sums(Arena& arena, MatchingArrays& arrays);

// Sets both views, in 1/16 px above min_px, in the bands of hexrelief::match_views(). The costs of a picture
// that is one band have to be found before.
void match_views(cudaStream_t stream, const MatchingArrays& arrays, const RasterView<std::int16_t>& left,
                 const RasterView<std::int16_t>& right, StageClock& clock);

}  // namespace hexrelief::cuda
