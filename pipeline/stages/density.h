// Stage: disparity map -> density map (paper, section 3: background removed, contrast raised by the cube).
#pragma once

#include "pipeline/data/density_map.h"
#include "pipeline/data/disparity_map.h"

namespace hexrelief {

enum class BackgroundMethod { none, fraction, threshold_px, otsu };

struct DensityConfig {
    double exponent = 3;  // 0..8; the paper's cube
    BackgroundMethod background_method = BackgroundMethod::fraction;
    double background_fraction = 0.25;   // of the largest known disparity; 0..1
    double background_threshold_px = 0;  // for threshold_px
    double floor = 0;                    // least density of a known pixel, share of the largest; 0..1
    // Share of the mesh that goes to curved regions and discontinuities (density_detail.h); 0..0.99, 0 = the
    // paper's cube alone.
    double detail = 0;
};

// density = (d / d_max)^exponent where d is known, positive and not below the background threshold, else
// `floor` where known, else 0; unknown pixels are always 0. Values in [0, 1]. An all-zero map is returned as
// it is.
DensityMap compute_density(const DisparityMap& map, const DensityConfig& config);

}  // namespace hexrelief
