// The thresholds of the surface stage, for the CPU and the device, with their units.
// mesher/surface/EXPERIMENTS.md has the figures by which they were chosen, and lists the guards, which may be
// halved or doubled without effect. "Error" below is the report's duo_rmse_near_px divided by that of the
// best other program at the same number of bytes.
#pragma once

#include <cstdint>

namespace hexrelief::step {

// --- Which neighbouring pixels lie on one surface ---
// px: neighbouring pixels whose disparities differ by more lie on two surfaces, if
// surface.least_discontinuity_px is 0. Both cameras see a surface that changes by less than a pixel per
// pixel; the part above 1 allows for rounding.
inline constexpr float kDiscontinuity_px = 1 + 1.0f / 64;
// px: a step up to this height may be spread over several pixels, and then only its steepest part is a
// discontinuity. Each higher step is a silhouette of its own, even beside a still higher one: otherwise
// triangles would span from the lowest surface there to the highest. Silhouettes at steps up to this height
// are not inset, because what shows through the gap would be more wrong than the step.
inline constexpr float kLowStep_px = 2.3f;
// A vertical step belongs to a slope if it exceeds kSlopeShare times the slope around it by at most the
// discontinuity threshold. The slope is the smaller of the mean steps over kSlopeReach_px rows above and
// below; means, because maps in whole pixels have uneven slopes. Each step in a mean counts as at most
// kSlopeMostStep times the step in question, because one high step makes no slope.
inline constexpr int kSlopeReach_px = 6;
inline constexpr float kSlopeShare = 2;
inline constexpr float kSlopeMostStep = 2;
// A vertical step does not part two surfaces either if lines through up to kLineReach_px pixels of the column
// on each side, at least kLineLeast_px, come within kMeeting_px of each other there and slope against the
// step by at most -kMeetingSlope; or if both slope with it by kFoldSlope and miss each other by no more than
// they rise in kFoldRows rows. Both pixels of the step lie within kLineOff_px of their lines.
inline constexpr int kLineReach_px = 12, kLineLeast_px = 3;
inline constexpr float kLineOff_px = 1.5f, kMeeting_px = 1.5f;
inline constexpr float kMeetingSlope = -0.1f;  // px per row
inline constexpr float kFoldSlope = 0.15f;     // px per row
inline constexpr float kFoldRows = 8;

// --- Holes and speckles: regions that are merged into their surroundings. Holes are smaller than
// a lattice cell ---
inline constexpr int kLeastRegion_px = 5;  // pixels: smaller regions are speckles

// --- Half-occlusion steps ---
inline constexpr float kLowHalfOcclusion_px = 4;  // px: lower half-occlusion steps are called low
inline constexpr int kHalfOcclusionReach_px = 2;  // pixels right of a low step that count as behind it
// Weight, in the fit of disparities, of a pixel behind a low step; other pixels weigh 1.
inline constexpr double kHalfOcclusionWeight = 20;

// --- Where silhouettes run ---
// Half the width of the window around a pixel in which the staircase of crack edges is straightened.
inline constexpr int kSilhouetteReach_px = 2;
inline constexpr float kSilhouetteFade_px = 0.75f;  // beyond the window: crack edges' weights fade to 0 here
// Length of the mean normal; below it the crack edge's own normal is used
inline constexpr float kLeastNormal = 0.1f;
// Squared sine of the angle between a vertex's path and a silhouette; below it the path
// runs along the silhouette.
inline constexpr float kLeastCrossing = 0.1f;
// Largest distance along a silhouette from its crack edge to the point nearest to a vertex.
inline constexpr float kMostAlong_px = 0.75f;
// Search range beyond the crossing, measured at the crack edges' midpoints, for the silhouette point
// nearest to a vertex.
inline constexpr float kNearestBeyond_px = 0.5f;
// Share of an edge: a crossing nearer than this to a vertex on a silhouette counts as that vertex.
inline constexpr float kOnSilhouetteShare = 0.3f;

// --- Snapping and splitting ---
inline constexpr float kSnapReach = 0.75f;   // share of an edge by which a vertex may move along it
inline constexpr float kLeastShape = 0.3f;   // least shape() of a moved triangle, unless it was worse before
inline constexpr float kLeastShare = 0.12f;  // least share of an edge between a split and either end

// --- Straddling triangles ---
inline constexpr std::uint32_t kStraddling_px = 2;  // least number of outliers of a straddling triangle
// px2: a triangle is split if its outliers cost more than this for each pixel of a lattice cell.
inline constexpr double kStraddlingError_px2 = 0.5;
// Largest error of an outlier that counts; larger errors, and holes, cost as much as this one.
inline constexpr double kMostError_px = 10;
// Error of a covered hole, as a share of the disparity that covers it
inline constexpr double kHoleWeight = 0.7;
// Weight of an outlier on a farther surface that the triangle covers: then the right camera, too, sees the
// nearer surface in a wrong place.
inline constexpr double kCoveredWeight = 4;

// --- Fit of silhouettes ---
inline constexpr int kSilhouetteRounds = 5;
// Crack edges within this distance of a mesh edge are fitted
inline constexpr float kSilhouetteFitReach_px = 1.5f;
// Least distance between an edge and the pixel centres along it
inline constexpr float kSilhouetteMargin_px = 0.05f;
inline constexpr float kSilhouetteBeyondWeight = 2;  // weight of crack edges at which that margin is violated
// Weight of staying in place, relative to a crack edge's. 0.1, 0.3, 0.6, 1: error 0.80, 0.80, 0.83, 0.84.
inline constexpr double kSilhouetteStayWeight = 0.3;
inline constexpr double kSilhouetteLeastShape = 0.1;  // least shape of a triangle, unless it was worse before
inline constexpr double kSilhouetteRest_px = 0.03;    // a vertex that would move less than this stays
// px: at low half-occlusion steps the silhouette is inset by this much into the nearer surface. The
// strip beside it that only the right camera sees is a few pixels wide, and an error of the
// silhouette would hide it.
inline constexpr float kLowInset_px = 410 / 1024.0f;  // a multiple of 1 / kPositionSteps
// px: distance that a vertex may move before the crack edges near its mesh edges are searched again. The
// value does not change the result, only how many crack edges are stored and how often they are searched.
inline constexpr float kSilhouetteStay_px = 1;

// --- Insets ---
inline constexpr int kInsetReach_px = 1;          // pixels around a vertex whose steps decide about its inset
inline constexpr double kInsetLeastShape = 0.05;  // least shape of a triangle at a moved vertex
// Least length of a silhouette edge, as a share of its original length
inline constexpr float kInsetLeastLength = 0.1f;

// --- Fit of disparities ---
inline constexpr int kFitSweeps = 4;  // sweeps of the linear solver
// 2 / (1/2 + 2), from the extreme eigenvalues of a triangle's scaled sums
inline constexpr double kFitDamping = 0.8;
inline constexpr double kFitPlaneWeight = 0.05;     // weight of the vertex's own plane, relative to a pixel's
inline constexpr double kPlaneLeastPixels = 6;      // least number of pixels that a plane is fitted to
inline constexpr double kPlaneLeastSpread_px2 = 2;  // their least sum of squared distances from the centroid
inline constexpr double kPlaneLeastWidth = 0.05;    // least determinant of that spread over its squared trace
// Least disparity of a vertex; half of the smallest disparity is another limit.
inline constexpr double kLowestDisparity_px = 1e-3;
// Least (2 * area / longest edge^2)^2 of a triangle whose sums are computed in closed form; in thinner ones
// the closed form loses digits.
inline constexpr double kFullLeastShape = 1e-3;

// --- Rounding ---
inline constexpr float kPositionSteps = 1024;  // positions are multiples of 1 / kPositionSteps px
// More than the rounding errors of positions and distances in float
inline constexpr float kRounding_px = 0.01f;

}  // namespace hexrelief::step
