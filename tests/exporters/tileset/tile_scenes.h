// Synthetic neighbouring tiles, each with its own origin, whose borders share their vertices.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "exporters/core/scene.h"

namespace hexrelief::tileset {

// A vertex in space, in integer steps.
using Cell = std::array<std::int64_t, 3>;

struct GridTile {
    SurfaceMesh mesh;
    std::array<double, 3> origin_m = {};
    std::array<double, 3> low_m = {}, high_m = {};  // of the positions in space
};

// Returns a tile of a hilly surface: the vertices of its columns and rows [first, last], taken every `every`
// lattice points. far: the steps from the origin of space to that of the surface.
inline GridTile grid_tile(std::array<int, 2> first, std::array<int, 2> last, int every, double step_m,
                          const Cell& far) {
    constexpr std::int64_t kSpacing = 640;  // steps between lattice points
    const auto cell_at = [&](int column, int row) -> Cell {
        const double height = 1500 * std::sin(0.23 * column) * std::cos(0.19 * row) + 37.3 * (column % 3);
        return {far[0] + column * kSpacing, far[1] - row * kSpacing, far[2] + std::llround(height)};
    };
    GridTile tile;
    const Cell origin = cell_at((first[0] + last[0]) / 2, (first[1] + last[1]) / 2);
    for (std::size_t k = 0; k < 3; ++k) tile.origin_m[k] = static_cast<double>(origin[k]) * step_m;
    tile.low_m = {INFINITY, INFINITY, INFINITY};
    tile.high_m = {-INFINITY, -INFINITY, -INFINITY};
    const int columns = (last[0] - first[0]) / every + 1, rows = (last[1] - first[1]) / every + 1;
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i) {
            const Cell cell = cell_at(first[0] + i * every, first[1] + j * every);
            std::array<float, 3> at{};
            for (std::size_t k = 0; k < 3; ++k) {
                at[k] = static_cast<float>(static_cast<double>(cell[k] - origin[k]) * step_m);
                const double place = static_cast<double>(cell[k]) * step_m;
                tile.low_m[k] = std::min(tile.low_m[k], place);
                tile.high_m[k] = std::max(tile.high_m[k], place);
            }
            tile.mesh.positions.push_back({at[0], at[1], at[2]});
            tile.mesh.normals.push_back({0, 0, 1});
            tile.mesh.texcoords.push_back(
                {static_cast<float>(i) / (columns - 1), static_cast<float>(j) / (rows - 1)});
            tile.mesh.image_points.push_back({static_cast<float>(i), static_cast<float>(j)});
            tile.mesh.disparities.push_back(10);
        }
    for (int j = 0; j + 1 < rows; ++j)
        for (int i = 0; i + 1 < columns; ++i) {
            const auto a = static_cast<std::uint32_t>(j * columns + i), b = a + 1,
                       c = a + static_cast<std::uint32_t>(columns), d = c + 1;
            tile.mesh.triangles.push_back({a, c, b});
            tile.mesh.triangles.push_back({b, c, d});
        }
    tile.mesh.metric = true;
    return tile;
}

}  // namespace hexrelief::tileset
