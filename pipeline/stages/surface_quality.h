// How well a surface reproduces the disparity map that it stands for.
#pragma once

#include "pipeline/data/disparity_map.h"
#include "pipeline/data/surface_mesh.h"

namespace hexrelief::stages {

// The most that one pixel's error counts, and what a pixel counts that no triangle covers.
inline constexpr double kErrorCap_px = 10;
inline constexpr double kBorderSlack_px = 0.5;  // of the figures with slack

// Pixels of the foreground are scored: known, above 0 and not background. Errors are roots of mean square
// errors of disparity, px, weighted by (disparity / largest)^3, so that near surfaces count more. "With
// slack": a pixel that no triangle covers, but whose centre is within kBorderSlack_px of one, takes the
// nearest point's disparity.
struct SurfaceQuality {
    double rmse_near_px = 0;  // left view, without slack
    // Both cameras' views, with slack: the scored pixels and those that only the right camera sees
    // (hidden_from_left). In the latter a surface more than 1 px in front of what lies behind is an error,
    // weighted by its own disparity: a rubber sheet that bridges a depth discontinuity. So both holes and
    // rubber sheets count.
    double duo_rmse_near_px = 0;
    // Away from discontinuities: as rmse_near_px, of the pixels with no discontinuity, background or unknown
    // pixel within 2 px.
    double flat_rmse_px = 0;
    double sheet_share = 0;     // share of the hidden pixels that a rubber sheet covers
    double coverage = 0;        // share of the scored pixels
    double slack_coverage = 0;  // the same with slack
    long long scored_pixels = 0;
    long long hidden_pixels = 0;
};

// Uses mesh.image_points, mesh.disparities and mesh.triangles alone. Disparities below background_px, those
// not above 0 and unknown ones are not scored. 0 everywhere where nothing is scored. The same for any number
// of threads (>= 1).
SurfaceQuality measure_surface_quality(const SurfaceMesh& mesh, const DisparityMap& map, float background_px,
                                       int threads);

}  // namespace hexrelief::stages
