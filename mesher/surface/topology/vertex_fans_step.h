// Walks through the fans of triangles around a vertex, which are connected by closed edges.
#pragma once

#include <cstdint>

#include "pipeline/base/host_device.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief::step {

// A split lattice with its triangles' labels. Neighbours, Open: types of pointers to
// three values per triangle.
template <typename Neighbours, typename Open>
struct FanView {
    const Triangle* triangles;
    Neighbours neighbours;
    Open open;
    const std::uint8_t* kept;
};

// Corner k of a triangle.
struct Corner {
    std::uint32_t triangle, k;
    HEXRELIEF_HD std::uint32_t number() const { return 3 * triangle + k; }
};

// Returns which corner of a triangle a vertex is.
HEXRELIEF_HD std::uint32_t corner_of(const Triangle& t, std::uint32_t vertex) {
    return t[0] == vertex ? 0u : t[1] == vertex ? 1u : 2u;
}

// Moves from a corner of a kept triangle to the same vertex's corner in the triangle across one of its
// two edges there: the edge to the next corner if `next`, else the edge from the last one. Returns
// false if that edge is open or no kept triangle lies across it. The lower triangle's entry decides
// whether an edge is open.
template <typename View>
HEXRELIEF_HD bool next_in_fan(const View& view, bool next, Corner& at) {
    const std::uint32_t t = at.triangle, edge = next ? at.k : (at.k + 2) % 3;
    const std::int32_t n = view.neighbours[t][edge];
    if (n < 0) return false;
    // all loads come before the first use, because each takes long on a GPU
    const std::uint32_t other = static_cast<std::uint32_t>(n), vertex = view.triangles[t][at.k];
    const Triangle corners = view.triangles[other];
    const std::uint8_t open[3] = {view.open[other][0], view.open[other][1], view.open[other][2]},
                       own_open = view.open[t][edge], kept = view.kept[other];
    const std::uint32_t k = corner_of(corners, vertex), back = next ? (k + 2) % 3 : k;
    if (!kept || (t < other ? own_open : back == 0 ? open[0] : back == 1 ? open[1] : open[2])) return false;
    at = {other, k};
    return true;
}

// Calls visit(corner) for the other corners of a corner's fan. In each of the two directions it stops
// when visit() returns false.
template <typename View, typename Visit>
HEXRELIEF_HD void each_of_fan(const View& view, const Corner& from, const Visit& visit) {
    for (int way = 0; way < 2; ++way) {
        Corner at = from;
        while (next_in_fan(view, way == 0, at)) {
            if (at.triangle == from.triangle) return;  // walked all around the vertex
            if (!visit(at)) return;
        }
    }
}

}  // namespace hexrelief::step
