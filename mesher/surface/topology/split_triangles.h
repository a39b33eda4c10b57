// Splits the lattice's triangles where their edges cross silhouettes.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/surface/pixels/pixel_surfaces.h"
#include "mesher/surface/topology/split_lattice_step.h"
#include "pipeline/base/thread_pool.h"
#include "pipeline/base/uninitialized_vector.h"
#include "pipeline/data/geometry.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief::surface {

struct SplitLattice {
    std::vector<Vec2f> points;      // the lattice's vertices, then those put on edges
    RawVector<Triangle> triangles;  // of positive area; inverted and degenerate ones are left out
    // the triangle across the edge from corner k to k + 1; -1: none
    RawVector<std::array<std::int32_t, 3>> neighbours;
    std::vector<std::uint8_t> changed;  // per triangle: step::Change since TriangleLabeler last saw it
};

// Returns the lattice's triangles, with those split whose edges still cross a silhouette. on_silhouette: one
// value per vertex, see snap_to_silhouettes().
SplitLattice split_at_silhouettes(const PixelSurfaces& surfaces, const HexMesh2D& mesh,
                                  const std::vector<std::uint8_t>& on_silhouette, ThreadPool& pool);

// Splits the edges of straddling triangles (see TriangleLabels) that cross a silhouette. Triangles that
// stay whole keep their numbers; the first part of a split triangle takes its number, and the other parts
// follow after all triangles.
void split_straddling(const PixelSurfaces& surfaces, std::span<const std::uint8_t> straddling,
                      SplitLattice& lattice, ThreadPool& pool);

}  // namespace hexrelief::surface
