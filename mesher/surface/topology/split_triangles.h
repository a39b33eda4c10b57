// Splits the lattice's triangles where their edges cross silhouettes.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/common/thread_pool.h"
#include "mesher/common/uninitialized_vector.h"
#include "mesher/surface/pixels/discontinuities.h"
#include "pipeline/data/geometry.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief::surface {

struct SplitLattice {
    std::vector<Vec2f> points;      // the lattice's, then those put on edges
    RawVector<Triangle> triangles;  // positive area, inverted and degenerate ones left out
    RawVector<std::array<std::int32_t, 3>> neighbours;  // across the edge from corner k to k + 1; -1: none
    enum Change : std::uint8_t { kSame, kMoved, kNew };
    std::vector<std::uint8_t> changed;  // a triangle: how, since TriangleLabeler last saw it
};

// The lattice's triangles, those whose edges still cross a silhouette split there. on_silhouette: of each
// vertex, see snap_to_silhouettes().
SplitLattice split_at_silhouettes(const PixelSurfaces& surfaces, const HexMesh2D& mesh,
                                  const std::vector<std::uint8_t>& on_silhouette, ThreadPool& pool);

// Splits the edges of straddling triangles, see TriangleLabels, where they cross a silhouette. Triangles that
// stay whole keep their numbers; the first part of a split one takes its number, others follow all others.
void split_straddling(const PixelSurfaces& surfaces, std::span<const std::uint8_t> straddling,
                      SplitLattice& lattice, ThreadPool& pool);

}  // namespace hexrelief::surface
