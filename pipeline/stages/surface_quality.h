// Measures how well a surface reproduces its disparity map.
#pragma once

#include <vector>

#include "pipeline/data/disparity_map.h"
#include "pipeline/data/surface_mesh.h"

namespace hexrelief::stages {

// Returns, row-major, the disparities of those pixels of the right view that the left camera does not see; 0
// at all other pixels. The left map (px; values not above 0 = unknown) is warped to x - d, nearer surfaces in
// front; neighbours whose disparities differ by at most 1 px are joined. A gap of 2 px or more between two
// visible pixels of a row is hidden from the left camera; the farther one of the two surfaces at its ends is
// continued there. Two kinds of gaps stay 0: those between whose ends the left map has unknown pixels, and
// pixels that would lie outside the left image.
std::vector<float> hidden_from_left(const DisparityMap& left, int threads);

// The largest error that one pixel counts, and the error of a pixel that no triangle covers.
inline constexpr double kErrorCap_px = 10;
inline constexpr double kBorderSlack_px = 0.5;  // for the figures with slack

// The pixels of the foreground are scored: known, above 0 and not background. Errors are root mean square
// errors of disparity in px, weighted by (disparity / largest disparity)^3, so that near surfaces count more.
// "With slack": a pixel that no triangle covers, but whose centre is within kBorderSlack_px of one, gets the
// disparity of the nearest point of a triangle.
struct SurfaceQuality {
    double rmse_near_px = 0;  // left view, without slack
    // Over both cameras' views, with slack: the scored pixels, and those that only the right camera sees
    // (hidden_from_left()). In the latter a surface more than 1 px in front of the hidden one is an
    // error, weighted by its own disparity: a rubber sheet that bridges a depth discontinuity. So both
    // holes and rubber sheets count.
    double duo_rmse_near_px = 0;
    // rmse_near_px over the pixels away from discontinuities: those with no discontinuity, background or
    // unknown pixel within 2 px.
    double flat_rmse_px = 0;
    double sheet_share = 0;     // share of the hidden pixels that a rubber sheet covers
    double coverage = 0;        // share of the scored pixels that triangles cover
    double slack_coverage = 0;  // coverage with slack
    long long scored_pixels = 0;
    long long hidden_pixels = 0;
};

// Measures a surface by its image_points, disparities and triangles; nothing else of `mesh` is used.
// Disparities that are unknown, not above 0 or below background_px are not scored; if none is scored, all
// figures are 0. The result is the same for any number of threads (>= 1).
SurfaceQuality measure_surface_quality(const SurfaceMesh& mesh, const DisparityMap& map, float background_px,
                                       int threads);

}  // namespace hexrelief::stages
