// Stage: disparity map -> density map (paper, section 3: background removed, contrast raised by the cube).
#pragma once

#include <functional>

#include "pipeline/data/density_map.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/value_range.h"

namespace hexrelief {

enum class BackgroundMethod { automatic, none, fraction, threshold_px, otsu };

struct DensityConfig {
    static constexpr ValueRange kExponent{0, 8};
    double exponent = 3;  // the paper's cube
    // The scale of disparities is this percentile of the known ones above 0, which a few wrong pixels do not
    // move. The paper's is 100, the largest.
    static constexpr ValueRange kScalePercentile{0, 100};
    double scale_percentile = 99.8;
    BackgroundMethod background_method = BackgroundMethod::automatic;
    static constexpr ValueRange kBackgroundFraction{0, 1};
    double background_fraction = 0.25;  // for automatic and fraction: share of the scale
    static constexpr ValueRange kBackgroundThreshold_px{0, 65536};
    double background_threshold_px = 0;  // for threshold_px
    static constexpr ValueRange kFloor{0, 1};
    double floor = 0.05;  // least density of a known pixel, share of the largest
    // Share of the mesh that goes to curved regions and discontinuities (density_detail.h); 0 = the paper's
    // cube alone.
    static constexpr ValueRange kDetail{0, 0.99};
    double detail = 0;
};

// density = (min(d, scale) / scale)^exponent where d is known, above 0 and not below the background
// threshold; at least `floor` where d is known, background as well, which spends less of the mesh on the
// foreground and keeps it regular; 0 where d is unknown. Values in [0, 1]. Without any known disparity above
// 0 all are 0.
//
// BackgroundMethod::automatic removes what is below `background_fraction` of the scale, but only if it is
// apart from the rest: along at least 80 % of the border between the two, disparities at least halve from one
// pixel to the next. Otherwise it removes nothing, because a threshold would cut through surfaces.
DensityMap compute_density(const DisparityMap& map, const DensityConfig& config, int threads = 1);

// What the density of a pixel depends on besides its own disparity.
struct DensityScale {
    float scale_px = 0;  // 0: no disparity is known and above 0
    float background_px = 0;
};

// A window of a map, of disparities in px.
struct MapWindow {
    int x = 0, y = 0, width = 0, height = 0;
    const float* values = nullptr;  // of the first row
    std::size_t stride = 0;         // from row to row

    const float* row(int k) const { return values + k * stride; }
};

// A map in strips of whole columns, from left to right, together as wide as the map.
struct MapInStrips {
    int strips = 1;
    // Calls take(strip, window) for windows of a strip that together are the strip, from the top: those of
    // one strip one after another, of several at once. Each call begins anew.
    std::function<void(const std::function<void(int strip, const MapWindow& window)>& take)> read;
};

// That of a map, which is read up to three times. Throws what reading throws.
DensityScale find_density_scale(const MapInStrips& map, const DensityConfig& config);

// The density of a part of the map, as compute_density() gives it there. config.detail is left out, which
// depends on the whole map.
DensityMap density_at_scale(const DisparityMap& part, const DensityScale& scale, const DensityConfig& config,
                            int threads = 1);

}  // namespace hexrelief
