// How well a surface reproduces the disparity map that it stands for.
#pragma once

#include "pipeline/data/disparity_map.h"
#include "pipeline/data/surface_mesh.h"

namespace hexrelief {

inline constexpr double kErrorCap_px =
    10;  // an error counts at most as much; so much counts what is not covered
inline constexpr double kBorderSlack_px = 0.5;  // of the figures with slack

// All are over the scored pixels: known, above 0 and not background. "near": weighted by (disparity /
// largest)^3, root of the weighted mean square, px. "with slack": a pixel that no triangle covers, but whose
// centre is within kBorderSlack_px of one, takes the nearest point's disparity.
struct ReliefQuality {
    double rmse_near_px = 0;
    // Both cameras' views: rmse near with slack, over the scored pixels and those that only the right camera
    // sees (hidden_from_left). There, a surface more than 1 px in front of what lies behind is an error,
    // weighted by its own disparity: a rubber mesh over a depth discontinuity. Holes and sheets are both
    // charged.
    double duo_rmse_near_px = 0;
    double flat_rmse_px =
        0;                   // rmse near over pixels with no discontinuity, background or unknown within 2 px
    double sheet_share = 0;  // of the hidden pixels: covered by rubber mesh
    double coverage = 0;     // share of the scored pixels
    double slack_coverage = 0;  // the same with slack
    long long scored_pixels = 0;
    long long hidden_pixels = 0;
};

// Uses mesh.image_points, mesh.disparities and mesh.triangles alone. Disparities below background_px, those
// not above 0 and unknown ones are not scored. 0 everywhere where nothing is scored. The same for any number
// of threads (>= 1).
ReliefQuality measure_relief(const SurfaceMesh& mesh, const DisparityMap& map, float background_px,
                             int threads);

}  // namespace hexrelief
