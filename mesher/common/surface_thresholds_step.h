// The thresholds of the surface stage, for the CPU and the device, with their units. The measurements by
// which some of them were chosen are in mesher/surface/EXPERIMENTS.md. "Error" is the report's
// duo_rmse_near_px divided by that of the best other program at the same number of bytes.
#pragma once

#include <cstdint>

namespace hexrelief::step {

// --- Which neighbouring pixels lie on one surface ---
// px: neighbours that differ by more lie on two surfaces, if surface.least_discontinuity_px is 0. A surface
// that changes by less than a pixel a pixel is visible to both cameras; what is above 1 is rounding.
inline constexpr float kDiscontinuity_px = 1 + 1.0f / 64;
// px: a step up to this height may be spread over several pixels, of which only the steepest part is a
// discontinuity. A higher one is a silhouette of its own, next to a still higher one as well: else triangles
// would span from the lowest surface there to the highest. Silhouettes at lower steps are not inset: what
// shows through the gap would be more wrong than the step.
inline constexpr float kLowStep_px = 2.3f;
// A step down a column is part of a slope where it is at most the threshold higher than kSlopeShare times the
// slope around it: the lesser of the mean steps over so many rows above and below. Means, because the slopes
// of maps in whole pixels are uneven. A step there counts up to kSlopeMostStep times this one's height,
// because one high step is no slope.
inline constexpr int kSlopeReach_px = 6;
inline constexpr float kSlopeShare = 2;
inline constexpr float kSlopeMostStep = 2;

// --- Holes and speckles: regions that join what surrounds them. Holes are smaller than a lattice cell ---
inline constexpr int kLeastRegion_px = 5;  // pixels: smaller regions are speckles

// --- Half-occlusion steps ---
inline constexpr float kLowHalfOcclusion_px = 4;  // px: below, a step is a low one
inline constexpr int kHalfOcclusionReach_px = 2;  // pixels right of a low step that lie behind it
// Weight of a pixel behind a low step in the disparities' fit; others weigh 1.
inline constexpr double kHalfOcclusionWeight = 20;

// --- Where silhouettes run ---
inline constexpr int kLeastEdge =
    36;  // sum over three channels of 0 .. 255: a step of the colours that is an edge
inline constexpr int kLeastEdgeContrast = 3;  // times the largest step beside it: an edge that stands out
// To either side of a pixel: the window in which the staircase of crack edges is straightened.
inline constexpr int kSilhouetteReach_px = 2;
inline constexpr float kSilhouetteFade_px = 0.75f;  // beyond the window, where the weights of cracks end
inline constexpr float kLeastNormal = 0.1f;  // length of the mean normal; below, the crack edge's own counts
inline constexpr float kLeastCrossing =
    0.1f;  // squared sine of an angle; below, a way runs along a silhouette
inline constexpr float kMostAlong_px =
    0.75f;  // along a silhouette, from its crack edge to the point nearest to a vertex
// Beyond the crossing, where the crack edges' middles are searched for the silhouette's point nearest to a
// vertex.
inline constexpr float kNearestBeyond_px = 0.5f;
// Of an edge: a crossing within this share from a vertex that lies on a silhouette is that vertex.
inline constexpr float kOnSilhouetteShare = 0.3f;

// --- Snapping and splitting ---
inline constexpr float kSnapReach = 0.75f;   // share of an edge that a vertex may move along it
inline constexpr float kLeastShape = 0.3f;   // shape() of a moved triangle, unless it was worse before
inline constexpr float kLeastShare = 0.12f;  // of an edge, from a split to either end

// --- Straddling triangles ---
inline constexpr std::uint32_t kStraddling_px = 2;  // outliers from which on a triangle can be straddling
// px2: a triangle whose outliers cost more than this at each pixel of a lattice cell is split.
inline constexpr double kStraddlingError_px2 = 0.5;
inline constexpr double kMostError_px =
    10;  // of an outlier; a larger error, or a hole, costs as much as this one
inline constexpr double kHoleWeight = 0.7;  // of a covered hole, as a share of the disparity that covers it
// Of an outlier on a farther surface, which the triangle covers: the right camera sees the nearer surface
// there as well, where it is not.
inline constexpr double kCoveredWeight = 4;

// --- Fit of silhouettes ---
inline constexpr int kSilhouetteRounds = 5;
inline constexpr float kSilhouetteFitReach_px = 1.5f;  // around an edge: crack edges that it is fitted to
inline constexpr float kSilhouetteMargin_px = 0.05f;   // between an edge and the pixel centres along it
inline constexpr float kSilhouetteBeyondWeight = 2;    // of crack edges where that margin is not kept
// Towards staying, in crack edges' weights. 0.1, 0.3, 0.6, 1: error 0.80, 0.80, 0.83, 0.84.
inline constexpr double kSilhouetteStayWeight = 0.3;
inline constexpr double kSilhouetteLeastShape = 0.2;  // of a triangle, unless it was worse before
inline constexpr double kSilhouetteRest_px = 0.03;    // of a vertex: it stays where it would move less
// px: at low half-occlusion steps the silhouette lies so far inside of the nearer surface. What the right
// camera alone sees beside it is only a few pixels wide, and an error of the silhouette would hide it.
inline constexpr float kLowInset_px = 410 / 1024.0f;  // a whole number of kPositionSteps
// px: how far a vertex may move before the crack edges around its edges are found anew. It changes no result,
// only how many crack edges are kept and how often they are found.
inline constexpr float kSilhouetteStay_px = 1;

// --- Insets ---
inline constexpr int kInsetReach_px = 1;          // around a vertex: pixels whose steps decide
inline constexpr double kInsetLeastShape = 0.05;  // of a triangle at a moved vertex
inline constexpr float kInsetLeastLength = 0.1f;  // of a silhouette's edge, as a share of what it was

// --- Fit of disparities ---
inline constexpr int kFitSweeps = 4;        // of the linear solver
inline constexpr double kFitDamping = 0.8;  // 2 / (1/2 + 2), extreme eigenvalues of a triangle's scaled sums
inline constexpr double kFitPlaneWeight = 0.05;      // towards the vertex's own plane, in pixels' weights
inline constexpr double kPlaneLeastPixels = 6;       // that a plane is fitted to
inline constexpr double kPlaneLeastSpread_px2 = 2;   // of them, squared distances from their centre
inline constexpr double kPlaneLeastWidth = 0.05;     // determinant of the spread over its trace squared
inline constexpr double kLowestDisparity_px = 1e-3;  // of a vertex, and half of the smallest disparity
// (Twice the area over the square of the longest edge) squared: sums in closed form of thinner triangles lose
// digits.
inline constexpr double kFullLeastShape = 1e-3;

// --- Rounding ---
inline constexpr float kPositionSteps = 1024;  // a px: places move by a whole number of them
inline constexpr float kRounding_px = 0.01f;   // more than positions and distances in floats are off

}  // namespace hexrelief::step
