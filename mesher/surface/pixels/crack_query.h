// One thread's queries about silhouettes: which discontinuities lie on a way, where the silhouette runs at a
// crack, which crack is nearest to a point.
#pragma once

#include "mesher/surface/pixels/crack_edges_step.h"
#include "mesher/surface/pixels/discontinuities_step.h"
#include "mesher/surface/pixels/edge_crossings_step.h"
#include "pipeline/data/geometry.h"

namespace hexrelief::surface {

// The first discontinuity on a way and, unless the first alone is wanted, the last.
struct WayDiscontinuities {
    bool found;
    step::Crack first, last;
};
WayDiscontinuities discontinuities_on(const step::PixelView& pixels, const step::Way& way, bool only_first);
inline bool has_discontinuity(const step::PixelView& pixels, const step::Way& way) {
    return discontinuities_on(pixels, way, true).found;
}

// The Query of the steps in edge_crossings_step.h.
struct CrackQuery {
    step::PixelView pixels;
    step::TileView tiles;

    WayDiscontinuities discontinuities_between(const Vec2f& a, const Vec2f& b, bool only_first) const {
        return discontinuities_on(pixels, step::way_between(a.x, a.y, b.x, b.y), only_first);
    }
    // The first one, or the last.
    step::Crossing walk(const Vec2f& a, const Vec2f& b, bool last) const {
        const WayDiscontinuities discontinuities = discontinuities_between(a, b, !last);
        return {discontinuities.found, last ? discontinuities.last : discontinuities.first};
    }
    // The staircase of cracks around c becomes a line: weighted mean of their middles, with the mean of their
    // normals; the middle of c is moved onto it. Sums are taken row by row, right before down.
    step::SilhouettePoint silhouette_point(const step::Crack& c) const;
    // The crack nearest to p within reach, the first of equals row by row, right before down; x < 0: none.
    step::Crack nearest_crack(const Vec2f& p, float reach_px) const;
};

}  // namespace hexrelief::surface
