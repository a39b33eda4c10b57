// The rules for moving lattice vertices onto silhouettes: in which order, how far, and which moves
// the image's border allows.
#pragma once

#include <cstdint>

#include "mesher/common/lattice_step.h"
#include "mesher/common/surface_thresholds_step.h"
#include "mesher/surface/topology/triangle_shape_step.h"
#include "pipeline/base/host_device.h"
#include "pipeline/data/geometry.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief::step {

// Returns the index of a vertex's k-th neighbour (see neighbour_offset()), or -1 beyond the border.
HEXRELIEF_HD int neighbour_at(const Lattice& lattice, int column, int row, int k) {
    const Offset o = neighbour_offset(row, k);
    const int c = column + o.column, r = row + o.row;
    return c >= 0 && r >= 0 && c < lattice.columns && r < lattice.rows ? r * lattice.columns + c : -1;
}

// Gives the i-th of the triangles in the up to four quads around a vertex, 0 <= i < 8. Returns false if it
// does not exist or does not touch the vertex.
HEXRELIEF_HD bool triangle_around(const Lattice& lattice, int column, int row, int i, Triangle& triangle) {
    const int c = column - 1 + (i >> 1 & 1), r = row - 1 + (i >> 2);
    if (c < 0 || r < 0 || c > lattice.columns - 2 || r > lattice.rows - 2) return false;
    triangle = quad_triangles(lattice.columns, c, r)[i & 1];
    const std::uint32_t v = static_cast<std::uint32_t>(row) * lattice.columns + column;
    return triangle[0] == v || triangle[1] == v || triangle[2] == v;
}

// The position of a lattice in the lattice of a larger map. If both have as many columns, it
// is the whole lattice.
struct LatticePart {
    // first: index of the part's first vertex in the whole lattice
    std::uint32_t columns, whole_columns, first;

    HEXRELIEF_HD std::uint32_t index_in_whole(std::uint32_t v) const {
        return first + v + v / columns * (whole_columns - columns);
    }
};

// True if vertex v is moved before `other`: the nearest crossing comes first. Equally near ones are
// ordered by a hash of the vertex, because in order along a straight silhouette they would all have to
// wait for each other.
HEXRELIEF_HD bool goes_before(const LatticePart& part, float share, std::uint32_t v, float other_share,
                              std::uint32_t other) {
    const auto place = [&](std::uint32_t vertex) {  // a hash without collisions
        std::uint32_t i = part.index_in_whole(vertex);
        i *= 2654435761u;
        i ^= i >> 15;
        i *= 2246822519u;
        return i ^ i >> 13;
    };
    return share < other_share || (share == other_share && place(v) < place(other));
}

// The edge of a vertex that crosses a silhouette nearest to it, and the crossing as a share of
// it; below 0: none.
struct NearestCrossing {
    int k = 0;
    float share = -1;
};

// Returns the nearest of the crossings share_at(k) of the six edges.
template <typename ShareAt>
HEXRELIEF_HD NearestCrossing nearest_crossing(const ShareAt& share_at) {
    NearestCrossing nearest;
    for (int k = 0; k < 6; ++k) {
        const float t = share_at(k);
        if (t < 0 || (nearest.share >= 0 && t >= nearest.share)) continue;
        nearest.k = k;
        nearest.share = t;
    }
    return nearest;
}

// Limits a vertex's target `to` to the image: border vertices slide along the image's border, corners stay.
// Returns true if the vertex may move.
HEXRELIEF_HD bool keep_in_image(const Vec2f& from, float width, float height, Vec2f& to) {
    const bool side = from.x <= 0 || from.x >= width, end = from.y <= 0 || from.y >= height;
    if (side && end) return false;
    if (side) to.x = from.x;
    if (end) to.y = from.y;
    to = {clamp_to(to.x, 0.0f, width), clamp_to(to.y, 0.0f, height)};
    return true;
}

}  // namespace hexrelief::step
