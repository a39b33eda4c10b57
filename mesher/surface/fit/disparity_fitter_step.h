// Fits the vertices' disparities to the triangles' own pixels by least squares, by a team of threads. A
// triangle's sums come from its pixels' moments, without reading the pixels again.
#pragma once

#include <cstddef>
#include <cstdint>

#include "mesher/common/surface_thresholds_step.h"
#include "mesher/surface/fit/fit_disparities_step.h"
#include "mesher/surface/pixels/discontinuities_step.h"
#include "mesher/surface/topology/rasterize_step.h"
#include "mesher/surface/topology/triangle_shape_step.h"
#include "pipeline/base/host_device.h"

namespace hexrelief::step {

// True if the triangle is not too thin for full_sums().
HEXRELIEF_HD bool holds_sums(const PlanePatch& p) {
    const double bcx = p.acx - p.abx, bcy = p.acy - p.aby;
    const double longest =
        max_of(p.abx * p.abx + p.aby * p.aby, max_of(p.acx * p.acx + p.acy * p.acy, bcx * bcx + bcy * bcy));
    return p.area * p.area > kFullLeastShape * (longest * longest);
}

// Returns the sums of add_pixel() over the pixels of the moments, all with weight 1.
HEXRELIEF_HD TriangleSums full_sums(const Moments& m, const PlanePatch& p) {
    // Coordinates are counted from a whole pixel near corner a first, then from the corner.
    const double column = static_cast<double>(static_cast<int>(p.x)),
                 row = static_cast<double>(static_cast<int>(p.y));
    const Moments o = from_pixel(m, column, row);
    const double u = p.x - 0.5 - column, v = p.y - 0.5 - row;
    const double ax = o.x - m.n * u, ay = o.y - m.n * v;
    const double axx = o.xx - u * (o.x + ax), axy = o.xy - u * o.y - v * ax, ayy = o.yy - v * (o.y + ay);
    const double axd = o.xd - u * m.d, ayd = o.yd - v * m.d;
    // A pixel's barycentric coordinates of corners b and c are bx x + by y and cx x + cy y.
    const double bx = p.acy / p.area, by = -p.acx / p.area, cx = -p.aby / p.area, cy = p.abx / p.area;
    const double b = bx * ax + by * ay, c = cx * ax + cy * ay;
    const double bb = bx * bx * axx + 2 * (bx * by) * axy + by * by * ayy,
                 bc = bx * cx * axx + (bx * cy + by * cx) * axy + by * cy * ayy,
                 cc = cx * cx * axx + 2 * (cx * cy) * axy + cy * cy * ayy;
    const double bd = bx * axd + by * ayd, cd = cx * axd + cy * ayd;
    return {{m.n - 2 * (b + c) + (bb + 2 * bc + cc), bb, cc},
            {b - bb - bc, bc, c - bc - cc},
            {m.d - bd - cd, bd, cd}};
}

// Successive runs of pixels.
struct PixelRuns {
    const surface::PixelRun* runs;
    std::size_t count;

    HEXRELIEF_HD const surface::PixelRun* begin() const { return runs; }
    HEXRELIEF_HD const surface::PixelRun* end() const { return runs + count; }
};

// The sums of a triangle: first its pixels' moments, then its part of the equations.
union FitTriangle {
    Moments moments;
    TriangleSums sums;
};

// A triangle's contribution to the equation of one of its vertices: its row, and its other two vertices.
struct FitTerm {
    CornerRow row;
    std::uint32_t next, last;
};

// A vertex's equation except for its terms: the coefficient of the unknown, and the disparity of the plane
// through the pixels around the vertex.
struct FitEquation {
    double diagonal, plane;
};

struct FitArrays {
    BucketView corners;      // per vertex: its corners as 3 * triangle + corner
    FitTriangle* triangles;  // per triangle
    FitTerm* terms;          // per corner, in the order of `corners`
    FitEquation* equations;  // per vertex
    double* values[2];       // per vertex: its disparity, before and after a sweep
};

// anchors: of the lattice's triangles. Runs: function from one of the lattice's triangles to the PixelRuns
// that its surface is fitted to.
template <typename Team, typename Runs>
class DisparityFitter {
  public:
    HEXRELIEF_TEAM DisparityFitter(Team& team, const PixelView& view, const TileView& tiles,
                                   const MeshTriangles& mesh, const Vec2f* points,
                                   const std::uint32_t* anchors, const Runs& runs, const FitArrays& arrays)
        : team_(team),
          view_(view),
          tiles_(tiles),
          mesh_(mesh),
          points_(points),
          anchors_(anchors),
          runs_(runs),
          a_(arrays) {}

    // Writes the vertices' disparities, at least `least`. All threads of the team call.
    HEXRELIEF_TEAM void fit(double least, float* disparities) const {
        sort_corners(team_, mesh_, a_.corners);
        team_.each(mesh_.count, [&](std::size_t t) { a_.triangles[t].moments = moments(t); });
        team_.each(mesh_.point_count,
                   [&](std::size_t v) { a_.values[0][v] = a_.equations[v].plane = start(v, least); });
        team_.each(mesh_.count, [&](std::size_t t) { a_.triangles[t].sums = sums(t); });
        team_.each(mesh_.point_count, [&](std::size_t v) { gather_terms(v); });
        for (int sweep = 0; sweep < kFitSweeps; ++sweep)
            team_.each(mesh_.point_count, [&](std::size_t v) {
                const double value = relaxed(v, a_.values[sweep % 2], least);
                if (sweep + 1 < kFitSweeps)
                    a_.values[(sweep + 1) % 2][v] = value;
                else
                    disparities[v] = static_cast<float>(value);
            });
    }

  private:
    HEXRELIEF_TEAM PixelRuns runs(std::size_t t) const { return runs_(mesh_.sources[t]); }

    // Sums up a triangle's pixels.
    HEXRELIEF_TEAM Moments moments(std::size_t t) const {
        Moments sum;
        for (const surface::PixelRun& run : runs(t)) {
            add_run(sum, run.y, run.first, run.end);
            const float* const row = view_.disparity + view_.index(0, run.y);
            for (int x = run.first; x < run.end; ++x) add_disparity(sum, x, run.y, row[x]);
        }
        return sum;
    }
    // Returns the vertex's disparity on a plane through the pixels around it; without pixels (all belong to
    // speckles) that of a triangle's own surface.
    HEXRELIEF_TEAM double start(std::size_t v, double least) const {
        Moments sum;
        const std::uint32_t *const first = a_.corners.begin(v), *const end = a_.corners.end(v);
        for (const std::uint32_t* i = first; i < end; ++i) add_moments(sum, a_.triangles[*i / 3].moments);
        const Vec2f& at = points_[v];
        return max_of(least, sum.n > 0 ? plane_at(sum, at.x, at.y)
                                       : view_.disparity[anchors_[mesh_.sources[*first / 3]]]);
    }
    // Returns a triangle's normal equations; those of most triangles follow from their moments.
    HEXRELIEF_TEAM TriangleSums sums(std::size_t t) const {
        const Triangle& v = mesh_.corners[t];
        const Vec2f &a = points_[v[0]], &b = points_[v[1]], &c = points_[v[2]];
        const PlanePatch patch = plane_patch(a.x, a.y, b.x, b.y, c.x, c.y);
        if (holds_sums(patch) && !is_behind_half_occlusion(t))
            return full_sums(a_.triangles[t].moments, patch);
        TriangleSums sums;
        for (const surface::PixelRun& run : runs(t))
            for (int x = run.first; x < run.end; ++x) {
                double l1, l2;
                pixel_shares(patch, x, run.y, l1, l2);
                add_pixel(sums, 1 - l1 - l2, l1, l2, view_.disparity[view_.index(x, run.y)],
                          fit_weight(view_, x, run.y));
            }
        return sums;
    }
    // True if one of the triangle's pixels lies behind a low half-occlusion step.
    HEXRELIEF_TEAM bool is_behind_half_occlusion(std::size_t t) const {
        const PixelRuns runs = this->runs(t);
        if (runs.count == 0) return false;
        int first = view_.width - 1, last = 0;
        for (const surface::PixelRun& run : runs)
            first = min_of(first, run.first), last = max_of(last, run.end - 1);
        first = max_of(0, first - kHalfOcclusionReach_px);
        if (!tiles_hold(tiles_, first, runs.runs[0].y, last, runs.runs[runs.count - 1].y)) return false;
        for (const surface::PixelRun& run : runs) {
            if (!has_discontinuity_before(view_, run.y, run.first, run.end)) continue;
            for (int x = run.first; x < run.end; ++x)
                if (is_behind_low_half_occlusion(view_, x, run.y)) return true;
        }
        return false;
    }
    // Collects the terms that a sweep needs of a vertex, and the coefficient of the unknown.
    HEXRELIEF_TEAM void gather_terms(std::size_t v) const {
        double diagonal = kFitPlaneWeight;
        for (unsigned i = a_.corners.starts[v]; i < a_.corners.ends[v]; ++i) {
            const std::uint32_t corner = a_.corners.items[i], k = corner % 3;
            const Triangle& t = mesh_.corners[corner / 3];
            const CornerRow row = corner_row(a_.triangles[corner / 3].sums, k);
            diagonal += row.own;
            a_.terms[i] = {row, t[(k + 1) % 3], t[(k + 2) % 3]};
        }
        a_.equations[v].diagonal = diagonal;
    }
    // Returns the vertex's disparity after a sweep.
    HEXRELIEF_TEAM double relaxed(std::size_t v, const double* values, double least) const {
        const FitEquation& e = a_.equations[v];
        double right = kFitPlaneWeight * e.plane;
        for (unsigned i = a_.corners.starts[v]; i < a_.corners.ends[v]; ++i) {
            const FitTerm& term = a_.terms[i];
            right += right_side(term.row, values[term.next], values[term.last]);
        }
        return step::relaxed(values[v], right, e.diagonal, least);
    }

    Team& team_;
    PixelView view_;
    TileView tiles_;
    MeshTriangles mesh_;
    const Vec2f* points_;
    const std::uint32_t* anchors_;
    const Runs& runs_;
    const FitArrays& a_;
};

}  // namespace hexrelief::step
