// Attributes as whole numbers on grids that are just fine enough for a tolerance.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "pipeline/data/calibration.h"
#include "pipeline/data/surface_mesh.h"

namespace hexrelief::exporters {

// value = origin + step * cell, axis by axis; cells lie in 0 .. largest.
template <int N>
struct Grid {
    std::array<double, N> origin{}, step{};
    std::array<std::int32_t, N> largest{};
    std::vector<std::array<std::int32_t, N>> cells;  // one a vertex

    double value(std::size_t vertex, int axis) const {
        return origin[axis] + step[axis] * cells[vertex][axis];
    }
    int bits() const;  // the fewest that hold every cell, at least 1
};

// How a grid's steps may differ between its axes.
enum class GridShape {
    per_axis,  // each axis has its own: for formats with a transform
    cubic,     // one step for all; where depths may be coarser, they use only every k-th cell
};

// The coarsest grid that keeps every vertex, as the camera sees it, within tolerance_px in x, in y and in
// disparity; of the cells that do so for a vertex, it gets the one that its neighbours predict best. Throws
// Error(output) where it takes more than 24 bits, which 32-bit floats cannot hold. tolerance_px > 0; the
// camera's focal length and baseline > 0; all positions lie in front of it.
Grid<3> quantise_positions(const SurfaceMesh& mesh, const Calibration& camera, double tolerance_px,
                           GridShape shape, int threads = 1);

// The grid that positions lie on already, which are whole multiples of `step`, of less than 2^24 steps.
Grid<3> exact_grid(const std::vector<Vec3f>& positions, double step);

// The coarsest grid that moves no texture coordinate by more than tolerance_px of a texture of that size, in
// x or in y. cubic: the steps are equal in texture coordinates, else in px. The origin is (0, 0), so that
// meshes with one texture have one grid. Throws as above.
Grid<2> quantise_texcoords(const std::vector<Vec2f>& texcoords, int width, int height, double tolerance_px,
                           GridShape shape);

}  // namespace hexrelief::exporters
