// Stage: from a disparity map to a density map (paper, section 3: background removed, contrast
// raised by the cube).
#pragma once

#include <functional>

#include "pipeline/data/density_map.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/value_range.h"

namespace hexrelief::stages {

enum class BackgroundMethod { automatic, none, fraction, threshold_px, otsu };

struct DensityConfig {
    static constexpr ValueRange kExponent{0, 8};
    double exponent = 3;  // the paper cubes
    // The scale of disparities is this percentile of the known disparities above 0, so that a few wrong
    // pixels do not move it. The paper uses 100, the largest disparity.
    static constexpr ValueRange kScalePercentile{0, 100};
    double scale_percentile = 99.8;
    BackgroundMethod background_method = BackgroundMethod::automatic;
    static constexpr ValueRange kBackgroundFraction{0, 1};
    double background_fraction = 0.25;  // for automatic and fraction: share of the scale
    static constexpr ValueRange kBackgroundThreshold_px{0, 65536};
    double background_threshold_px = 0;  // used by threshold_px
    static constexpr ValueRange kFloor{0, 1};
    double floor = 0.05;  // density of known pixels is at least this share of the largest
    // Share of the mesh that goes to curved regions and discontinuities (density_detail.h); 0 =
    // none, as in the paper.
    static constexpr ValueRange kDetail{0, 0.99};
    double detail = 0;
};

// Returns a density in [0, 1] per pixel:
// - foreground (d known, above 0 and not below the background threshold): (min(d, scale) /
//   scale)^exponent, at least `floor`;
// - other known pixels, the background: `floor`, which spends less of the mesh on the foreground
//   and keeps it regular;
// - unknown pixels: 0.
//
// All densities are 0 if no disparity is known and above 0.
//
// BackgroundMethod::automatic removes disparities below `background_fraction` of the scale, but only if along
// 80 % of their border with the rest disparities at least halve from one pixel to the next, and the rest is a
// tenth of the known pixels or more: else it would cut through surfaces, or leave next to nothing. A scale
// that less than 0.5 % of the picture reaches, and 1.5 times what 0.5 % reach, is the latter instead.
//
// Throws Error(usage) if a parameter is out of range.
DensityMap compute_density(const DisparityMap& map, const DensityConfig& config, int threads = 1);

// The properties of the whole map that a pixel's density depends on besides its own disparity.
struct DensityScale {
    float scale_px = 0;  // 0: no disparity is known and above 0
    float background_px = 0;
};

// A window of a disparity map, in px.
struct MapWindow {
    int x = 0, y = 0, width = 0, height = 0;
    const float* values = nullptr;  // first row of the window
    std::size_t stride = 0;         // distance between rows, in values

    const float* row(int k) const { return values + k * stride; }
};

// A disparity map read in vertical strips, numbered from left to right, which together are as
// wide as the map.
struct MapInStrips {
    int strips = 1;
    // Reads the map: calls take(strip, window) for windows that cover each strip from top to bottom. The
    // windows of one strip come one after another; different strips may come at the same time, from several
    // threads. Each call of read() starts again.
    std::function<void(const std::function<void(int strip, const MapWindow& window)>& take)> read;
};

// Returns the scale and background threshold of a map, which is read up to four times. Throws Error(usage)
// if a parameter is out of range, and whatever reading throws.
DensityScale find_density_scale(const MapInStrips& map, const DensityConfig& config);

// Returns the densities of a part of the map, equal to those that compute_density() gives it for
// config.detail = 0. config.detail is ignored, because it depends on the whole map.
DensityMap density_at_scale(const DisparityMap& part, const DensityScale& scale, const DensityConfig& config,
                            int threads = 1);

}  // namespace hexrelief::stages
