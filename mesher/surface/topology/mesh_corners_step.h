// The cut mesh's triangles, and the corners at each of its vertices.
#pragma once

#include <cstddef>
#include <cstdint>

#include "mesher/common/team_sort_step.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief::step {

struct MeshTriangles {
    unsigned point_count, count;
    const Triangle* corners;
    const std::uint32_t* sources;  // in the split lattice
};

// Lists for each vertex its corners as 3 * triangle + corner; there must be room for all.
template <typename Team>
HEXRELIEF_TEAM void sort_corners(Team& team, const MeshTriangles& mesh, const BucketView& corners) {
    sort_into(team, mesh.point_count, corners, [&](const auto& put) {
        team.each(mesh.count, [&](std::size_t t) {
            for (std::uint32_t k = 0; k < 3; ++k)
                put(mesh.corners[t][k], 3 * static_cast<std::uint32_t>(t) + k);
        });
    });
}

}  // namespace hexrelief::step
