// Tests levels of detail: fewer triangles, the same borders.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "mesher/tiles/coarser_tile.h"

namespace hexrelief::mesh_tiles {
namespace {

using Edge = std::array<TileCorner, 2>;

// Returns a part of a lattice of squares of 4 px, each cut into two triangles, whose disparities form a hill.
// The outer edges that another part shares are seam edges.
TileMesh hill(int first_column, int columns, int rows, int all_columns) {
    TileMesh mesh;
    const auto corner = [](int column, int row) {
        const double x = column - 20.3, y = row - 15.7;
        return TileCorner{{column * 4096, row * 4096},
                          static_cast<float>(40 + 10 * std::exp(-(x * x + y * y) / 90))};
    };
    for (int row = 0; row <= rows; ++row)
        for (int column = first_column; column <= first_column + columns; ++column)
            mesh.corners.push_back(corner(column, row));
    const auto at = [&](int column, int row) {
        return static_cast<std::uint32_t>(row * (columns + 1) + column);
    };
    for (int row = 0; row < rows; ++row) {
        for (int column = 0; column < columns; ++column) {
            mesh.triangles.push_back({at(column, row), at(column + 1, row), at(column, row + 1)});
            mesh.triangles.push_back({at(column + 1, row), at(column + 1, row + 1), at(column, row + 1)});
        }
        const int last = first_column + columns;
        if (first_column > 0)
            mesh.seam_edges.push_back({corner(first_column, row + 1), corner(first_column, row)});
        if (last < all_columns) mesh.seam_edges.push_back({corner(last, row), corner(last, row + 1)});
    }
    std::sort(mesh.seam_edges.begin(), mesh.seam_edges.end());
    return mesh;
}

double depth_of(double disparity) {
    return 100 / disparity;
}

std::int64_t twice_area_of(const TileMesh& mesh, const Triangle& t) {
    const Place &a = mesh.corners[t[0]].place, &b = mesh.corners[t[1]].place, &c = mesh.corners[t[2]].place;
    return std::int64_t{b.x - a.x} * (c.y - a.y) - std::int64_t{b.y - a.y} * (c.x - a.x);
}

std::int64_t covered(const TileMesh& mesh) {
    std::int64_t sum = 0;
    for (const Triangle& t : mesh.triangles) sum += twice_area_of(mesh, t);
    return sum;
}

std::set<Edge> edges_of(const TileMesh& mesh) {
    std::set<Edge> edges;
    for (const Triangle& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k) edges.insert({mesh.corners[t[k]], mesh.corners[t[(k + 1) % 3]]});
    return edges;
}

TEST(CoarserTile, KeepsItsSeamsAndFoldsNowhere) {
    // Two tiles of three: the seam between them disappears, the one to the third stays.
    const std::vector<TileMesh> tiles = {hill(0, 20, 30, 60), hill(20, 20, 30, 60)};
    const CoarserTile coarser = coarser_tile(tiles, tiles, 0.25, depth_of);
    const std::size_t before = tiles[0].triangles.size() + tiles[1].triangles.size();
    EXPECT_LT(coarser.mesh.triangles.size(), before / 3);
    EXPECT_GT(coarser.mesh.triangles.size(), before / 5);
    EXPECT_EQ(coarser.mesh.seam_edges.size(), 30u);
    const std::set<Edge> edges = edges_of(coarser.mesh);
    for (const Edge& edge : coarser.mesh.seam_edges) {
        EXPECT_TRUE(edges.contains(edge));
        EXPECT_FALSE((edges.contains({edge[1], edge[0]})));
    }
    for (const Triangle& t : coarser.mesh.triangles) EXPECT_GT(twice_area_of(coarser.mesh, t), 0);
    EXPECT_EQ(covered(coarser.mesh), covered(tiles[0]) + covered(tiles[1]));
    // the tiles' own corners, to the bit
    std::set<TileCorner> corners(tiles[0].corners.begin(), tiles[0].corners.end());
    corners.insert(tiles[1].corners.begin(), tiles[1].corners.end());
    for (const TileCorner& corner : coarser.mesh.corners) EXPECT_TRUE(corners.contains(corner));
}

TEST(CoarserTile, MeasuresItsError) {
    const std::vector<TileMesh> tiles = {hill(0, 40, 30, 40)};
    double last = 0;
    for (const double share : {0.5, 0.1, 0.02}) {
        const CoarserTile coarser = coarser_tile(tiles, tiles, share, depth_of);
        EXPECT_GT(coarser.error_px, last);
        EXPECT_LT(coarser.error_px, 3);
        // 100 / d from 50 to 40 px: 0.04 to 0.0625 m per px
        EXPECT_GT(coarser.error_m, 0.04 * coarser.error_px);
        EXPECT_LT(coarser.error_m, 0.0625 * coarser.error_px);
        last = coarser.error_px;
    }
}

TEST(CoarserTile, IsAsGoodFromTilesSimplifiedAlone) {
    const std::vector<TileMesh> tiles = {hill(0, 20, 30, 60), hill(20, 20, 30, 60)};
    std::vector<TileMesh> parts;
    for (const TileMesh& tile : tiles) {
        parts.push_back(simplified_alone(tile, 0.25));
        EXPECT_LT(parts.back().triangles.size(), tile.triangles.size() / 2);
        EXPECT_GT(parts.back().triangles.size(), tile.triangles.size() / 4);
        EXPECT_EQ(parts.back().seam_edges, tile.seam_edges);
    }
    const CoarserTile at_once = coarser_tile(tiles, tiles, 0.25, depth_of),
                      coarser = coarser_tile(tiles, parts, 0.25, depth_of);
    EXPECT_NEAR(static_cast<double>(coarser.mesh.triangles.size()),
                static_cast<double>(at_once.mesh.triangles.size()), 30);
    EXPECT_LT(coarser.error_px, 1.2 * at_once.error_px);
    EXPECT_EQ(coarser.mesh.seam_edges, at_once.mesh.seam_edges);
    EXPECT_EQ(covered(coarser.mesh), covered(at_once.mesh));
}

TEST(CoarserTile, OfLittleOrNothing) {
    EXPECT_TRUE(coarser_tile({}, {}, 0.25, depth_of).mesh.empty());
    const std::vector<TileMesh> tiles = {{}, hill(0, 1, 1, 1), {}};
    const CoarserTile coarser = coarser_tile(tiles, tiles, 0.25, depth_of);
    EXPECT_FALSE(coarser.mesh.empty());
    EXPECT_LE(coarser.mesh.triangles.size(), 2u);
}

}  // namespace
}  // namespace hexrelief::mesh_tiles
