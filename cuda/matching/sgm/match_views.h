// Semi-global matching on the device: the winners of both views.
#pragma once

#include "cuda/matching/common/workspace.h"
#include "cuda/matching/sgm/pictures.h"
#include "cuda/matching/sgm/volume.h"

namespace hexrelief::cuda {

struct SearchConfig {
    matching::DisparityRange range;  // count: 1..kMostDisparities
    step::PathPenalties penalties;
};
struct DeviceViews {
    matching::RasterView<std::int16_t> left, right;  // right.origin null: the right view is not wanted
};
// Sets both views, in 1/16 px above range.min_px, band by band. half: see find_path_pixels(). Memory taken
// from the arena is given back.
void match_views(Workspace& work, const PairArrays& pair, const SearchConfig& config,
                 const matching::RasterView<std::int16_t>& half, const DeviceViews& views);

}  // namespace hexrelief::cuda
