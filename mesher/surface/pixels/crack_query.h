// One thread's queries about silhouettes: which discontinuities lie on a path, where the silhouette runs at a
// crack edge, which crack edge is nearest to a point.
#pragma once

#include "mesher/surface/pixels/crack_edges_step.h"
#include "mesher/surface/pixels/discontinuities_step.h"
#include "mesher/surface/pixels/edge_crossings_step.h"
#include "pipeline/data/geometry.h"

namespace hexrelief::surface {

// The first discontinuity on a path and, unless only the first is wanted, the last.
struct WayDiscontinuities {
    bool found;
    step::Crack first, last;
};
WayDiscontinuities discontinuities_on(const step::PixelView& pixels, const step::Way& way, bool only_first);
inline bool has_discontinuity(const step::PixelView& pixels, const step::Way& way) {
    return discontinuities_on(pixels, way, true).found;
}

// The Query type of the steps in edge_crossings_step.h.
struct CrackQuery {
    step::PixelView pixels;
    step::TileView tiles;

    WayDiscontinuities discontinuities_between(const Vec2f& a, const Vec2f& b, bool only_first) const {
        return discontinuities_on(pixels, step::way_between(a.x, a.y, b.x, b.y), only_first);
    }
    // Returns the first discontinuity on the path from a to b, or the last.
    step::Crossing walk(const Vec2f& a, const Vec2f& b, bool last) const {
        const WayDiscontinuities discontinuities = discontinuities_between(a, b, !last);
        return {discontinuities.found, last ? discontinuities.last : discontinuities.first};
    }
    // Straightens the staircase of crack edges around c to a line, through the weighted mean of their
    // midpoints and with their mean normal, and moves the midpoint of c onto it. Sums are taken row by
    // row, right before down.
    step::SilhouettePoint silhouette_point(const step::Crack& c) const;
    // Returns the crack edge nearest to p within reach; of equally near ones the first row by row, right
    // before down. x < 0: none.
    step::Crack nearest_crack(const Vec2f& p, float reach_px) const;
};

}  // namespace hexrelief::surface
