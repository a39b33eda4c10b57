// Fits mesh edges along silhouettes to crack edges: the residuals of a mesh edge, and the target of a
// vertex between mesh edges.
#pragma once

#include <cmath>

#include "mesher/common/surface_thresholds_step.h"
#include "mesher/surface/pixels/crack_edges_step.h"
#include "mesher/surface/pixels/discontinuities_step.h"
#include "pipeline/base/host_device.h"
#include "pipeline/data/geometry.h"

namespace hexrelief::step {

// True if a triangle's edge with an inner neighbour lies on a silhouette. kept: true if the triangle is kept.
HEXRELIEF_HD bool is_silhouette(bool kept, bool neighbour_kept, bool open) {
    return (kept != neighbour_kept) | (kept & open);
}

// A crack edge as a sample: its midpoint, and the direction to its nearer pixel, 1 or -1 along one axis. Low
// half-occlusion steps are inset by kLowInset_px.
struct SilhouetteSample {
    float x, y, near_x, near_y;
};

HEXRELIEF_HD SilhouetteSample silhouette_sample(const PixelView& view, const Crack& c) {
    const std::size_t i = view.index(c.x, c.y);
    const float first = view.disparity[i], second = view.disparity[c.down ? i + view.width : i + 1];
    const Middle middle = crack_middle(c);
    const float towards = first > second ? -1.0f : 1.0f;
    const bool inset = (!c.down) & is_low_half_occlusion(first, second);
    return {middle.x - (inset ? kLowInset_px : 0.0f), middle.y, c.down ? 0.0f : towards,
            c.down ? towards : 0.0f};
}

// A mesh edge from (x, y), with its squared length and its unit normal (-dy, dx) / length, which points
// into its own triangle.
struct SilhouetteEdgeFrame {
    float x, y, dx, dy, size2, nx, ny;
};

HEXRELIEF_HD SilhouetteEdgeFrame silhouette_edge_frame(const Vec2f& a, const Vec2f& b) {
    const float dx = b.x - a.x, dy = b.y - a.y, size2 = dx * dx + dy * dy;
    if (!(size2 > 0)) return {a.x, a.y, dx, dy, 0, 0, 0};
    const float size = std::sqrt(size2);
    return {a.x, a.y, dx, dy, size2, -dy / size, dx / size};
}

// The pixels, last ones included, whose crack edges can lie within a distance of a mesh edge.
struct PixelBox {
    int x0, x1, y0, y1;
};

HEXRELIEF_HD PixelBox pixels_around(const PixelView& view, const Vec2f& a, const Vec2f& b, float around_px) {
    const auto low = [&](float u, float v) {
        return max_of(0, static_cast<int>(min_of(u, v) - around_px) - 1);
    };
    const auto high = [&](float u, float v, int last) {
        return min_of(last, static_cast<int>(max_of(u, v) + around_px) + 1);
    };
    return {low(a.x, b.x), high(a.x, b.x, view.width - 1), low(a.y, b.y), high(a.y, b.y, view.height - 1)};
}

// The residual of a crack edge in the frame of the mesh edge that is fitted to it.
struct SilhouetteResidual {
    float share, residual;  // share of the way along the mesh edge; distance from it, px
    float weight;           // 0 if it is out of reach or perpendicular
    float across;           // cosine between the normal and the direction to the nearer pixel, -1 .. 1
};

HEXRELIEF_HD SilhouetteResidual silhouette_residual(const SilhouetteEdgeFrame& e,
                                                    const SilhouetteSample& side) {
    const float mx = side.x - e.x, my = side.y - e.y;
    const float s = (mx * e.dx + my * e.dy) / e.size2, r = mx * e.nx + my * e.ny;
    const float across = side.near_x * e.nx + side.near_y * e.ny;
    const float away = r / kSilhouetteFitReach_px;
    // at such a distance one of the crack edge's two pixels is on the wrong side of the mesh
    // edge, or nearly so
    const float beyond =
        std::fabs(r) > 0.5f * std::fabs(across) - kSilhouetteMargin_px ? kSilhouetteBeyondWeight : 1.0f;
    const float w = (1 - away * away) * beyond;
    const bool within = (s >= 0) & (s <= 1) & (r <= kSilhouetteFitReach_px) & (r >= -kSilhouetteFitReach_px);
    return {s, r, w * static_cast<float>(within & (across != 0)), across};
}

// Weights and weighted residuals of a mesh edge, distributed to its first and second vertex.
struct SilhouetteResiduals {
    double weights[2], residuals[2];  // residuals weighted
};

// Adds a sample. facing: the sum of weight * across of all samples of the edge, whose sign says on which side
// of the edge the nearer surface lies. Only samples that agree with it count.
HEXRELIEF_HD void add_residual(SilhouetteResiduals& sums, const SilhouetteResidual& sample, double facing) {
    const double weight = sample.across * facing > 0 ? sample.weight : 0;
    const double first = weight * (1 - sample.share), second = weight * sample.share;
    sums.weights[0] += first;
    sums.residuals[0] += first * sample.residual;
    sums.weights[1] += second;
    sums.residuals[1] += second * sample.residual;
}

// The normal equations of a silhouette vertex, from the edges at it.
struct SilhouetteEquation {
    double xx = 0, xy = 0, yy = 0, x = 0, y = 0;
};

HEXRELIEF_HD void add_edge(SilhouetteEquation& e, double nx, double ny, double weight, double residual) {
    e.xx += weight * nx * nx;
    e.xy += weight * nx * ny;
    e.yy += weight * ny * ny;
    e.x += residual * nx;
    e.y += residual * ny;
}

// Returns the target of a vertex at `from`. Vertices on the image's border stay on it, and none leaves the
// image. A vertex that would move less than kSilhouetteRest_px stays at `from`.
HEXRELIEF_HD Vec2f silhouette_target(SilhouetteEquation e, const Vec2f& from, float width, float height) {
    e.xx += kSilhouetteStayWeight;
    e.yy += kSilhouetteStayWeight;
    const double determinant = e.xx * e.yy - e.xy * e.xy;
    double ux = (e.x * e.yy - e.y * e.xy) / determinant, uy = (e.y * e.xx - e.x * e.xy) / determinant;
    if (ux * ux + uy * uy < kSilhouetteRest_px * kSilhouetteRest_px) return from;
    if (from.x <= 0 || from.x >= width) ux = 0;
    if (from.y <= 0 || from.y >= height) uy = 0;
    return {clamp_to(moved_by(from.x, static_cast<float>(ux)), 0.0f, width),
            clamp_to(moved_by(from.y, static_cast<float>(uy)), 0.0f, height)};
}

}  // namespace hexrelief::step
