// The structured hexagonal mesh in the image plane.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipeline/data/geometry.h"

namespace hexrelief {

// The lattice has columns x rows vertices, row-major; odd rows are shifted right by half the spacing.
// Positions are in px of the left image: pixel (x, y) is the unit square with its centre at +0.5. Each
// quad of the lattice is two triangles, whose signed area (x right, y down) is positive in the
// undeformed lattice: see quad_triangles().
struct HexMesh2D {
    int columns = 0;
    int rows = 0;
    std::vector<Vec2f> positions;  // columns * rows
    // Parallel iterations of all levels that trained it; draws / cells for MeshMethod::sequential.
    int iterations = 0;

    std::size_t index(int column, int row) const { return static_cast<std::size_t>(row) * columns + column; }
    const Vec2f& at(int column, int row) const { return positions[index(column, row)]; }
    std::size_t triangle_count() const {
        return columns < 2 || rows < 2 ? 0 : 2 * static_cast<std::size_t>(columns - 1) * (rows - 1);
    }
};

using Triangle = std::array<std::uint32_t, 3>;

// Returns, as vertex indices, the two triangles of the quad whose top left vertex is (column, row); 0 <=
// column < columns - 1, 0 <= row < rows - 1. Their signed area is positive in the undeformed lattice.
constexpr std::array<Triangle, 2> quad_triangles(int columns, int column, int row) {
    const auto at = [&](int c, int r) { return static_cast<std::uint32_t>(r) * columns + c; };
    const std::uint32_t a = at(column, row), b = at(column + 1, row), c = at(column, row + 1),
                        d = at(column + 1, row + 1);
    if (row & 1) return {Triangle{a, d, c}, Triangle{a, b, d}};
    return {Triangle{a, b, c}, Triangle{b, d, c}};
}

}  // namespace hexrelief
