// Quantises attributes to integers on grids that are just fine enough for a tolerance.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "pipeline/data/calibration.h"
#include "pipeline/data/surface_mesh.h"

namespace hexrelief::exporters {

struct CellRange {
    std::int32_t low = 0, high = 0;  // inclusive
};

// The pairs of triangles across whose common edge mesh coders predict: for an edge (a, b) of two triangles
// (a, b, c) and (b, a, d) the prediction is d = a + b - c.
class GridNeighbours {
  public:
    GridNeighbours(const std::vector<Triangle>& triangles, std::size_t vertex_count);
    // Chooses one coordinate of all vertices, each within its range: starts from the middles of
    // the ranges and lowers the sum of |a + b - c - d| over all inner edges, vertex by vertex in
    // their order, `sweeps` times.
    std::vector<std::int32_t> smooth(const std::vector<CellRange>& ranges, int sweeps) const;

  private:
    struct Term {
        // An inner edge has residual 0 if the vertex is plus1 + plus2 - minus.
        std::uint32_t plus1, plus2, minus;
    };
    std::vector<std::uint32_t> starts_;  // terms of vertex v: starts_[v] .. starts_[v + 1] - 1
    std::vector<Term> terms_;
};

// A grid of integer cells in 0 .. largest: value = origin + step * cell, axis by axis.
template <int N>
struct Grid {
    std::array<double, N> origin{}, step{};
    std::array<std::int32_t, N> largest{};
    std::vector<std::array<std::int32_t, N>> cells;  // one per vertex; the least on each axis is 0

    double value(std::size_t vertex, int axis) const {
        return origin[axis] + step[axis] * cells[vertex][axis];
    }
    int bits() const;  // fewest bits that hold every cell, at least 1
};

// The relation of a grid's steps between its axes.
enum class GridShape {
    per_axis,  // each axis has its own step: for formats with a transform
    cubic,     // one step for all axes; depths use only every k-th cell if they may be coarser
};

// Returns the coarsest grid that keeps every vertex, as the camera sees it, within tolerance_px in x, in y
// and in disparity. Of the cells within a vertex's tolerance, the vertex gets the one that is best
// predicted from its neighbours. Preconditions: tolerance_px > 0, the camera's focal length and baseline >
// 0, all positions in front of the camera. Throws Error(output) if the grid needs more than 24 bits, which
// 32-bit floats cannot hold.
Grid<3> quantise_positions(const SurfaceMesh& mesh, const Calibration& camera, double tolerance_px,
                           GridShape shape, int threads = 1);

// Returns the grid of positions that are already multiples of `step`, of less than 2^24 steps.
Grid<3> exact_grid(const std::vector<Vec3f>& positions, double step);

// Returns the coarsest grid that moves no texture coordinate by more than tolerance_px, in px of a texture of
// that size, in x or in y. cubic: the steps are equal in texture coordinates; per_axis: equal in px. The
// origin is (0, 0), so that meshes with one texture have the same grid. Throws Error(output) if the grid
// needs more than 24 bits.
Grid<2> quantise_texcoords(const std::vector<Vec2f>& texcoords, int width, int height, double tolerance_px,
                           GridShape shape);

}  // namespace hexrelief::exporters
