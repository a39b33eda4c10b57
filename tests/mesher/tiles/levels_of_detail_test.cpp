// Tests levels of detail of a relief with silhouettes and holes across the borders of its tiles: each level
// fits the neighbours of every other level to the bit.
#include "mesher/tiles/coarser_tile.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "tests/mesher/busy_map.h"

namespace hexrelief::mesh_tiles::testing_levels {
namespace {

constexpr int kCells = 16, kCell_px = 4;  // cells of a tile's side; side of a cell

// Returns twice the area of the triangle a b c, in the square of Place's unit.
std::int64_t twice_area(const Place& a, const Place& b, const Place& c) {
    return (std::int64_t{b.x} - a.x) * (std::int64_t{c.y} - a.y) -
           (std::int64_t{b.y} - a.y) * (std::int64_t{c.x} - a.x);
}

// A relief by positions in cells, with a surface on each side of its silhouettes.
struct MadeUpRelief {
    int tiles = 2;  // in each direction
    bool discs = true;

    int cells() const { return tiles * kCells; }
    // Returns the surface at a point: 0: the ground, 1: a disc, 2: a hole.
    int surface(double x, double y) const {
        if (!discs) return 0;
        const double middle = cells() / 2, r = std::hypot(x - middle - 0.3, y - middle + 5);
        if (std::hypot(x - 9, y - 30) < 4) return 2;  // holes ...
        return r < 11 ? 1 : 0;                        // ... across borders of tiles
    }
    float disparity(int column, int row, int of_surface) const {
        const float noise = testing_mesher::uniform(5, column, row);
        return 20 + 0.1f * static_cast<float>(column) + 25 * static_cast<float>(of_surface) +
               2 * std::sin(0.3f * static_cast<float>(row)) + 0.05f * noise;
    }

    // Returns the triangles of a grid whose vertices are slightly displaced; each belongs to the
    // surface at its centre.
    TileMesh tile(int i, int j) const {
        TileMesh mesh;
        std::map<TileCorner, std::uint32_t> numbers;
        std::map<std::array<TileCorner, 2>, bool> edges;  // edges of the tile's own triangles, and of others
        for (int row = 0; row < cells(); ++row)
            for (int column = 0; column < cells(); ++column) {
                const bool own = column / kCells == i && row / kCells == j;
                const int near = kCells / 4;
                if (column < i * kCells - near || column >= (i + 1) * kCells + near ||
                    row < j * kCells - near || row >= (j + 1) * kCells + near)
                    continue;
                for (const bool lower : {false, true}) {
                    const std::array<std::array<int, 2>, 3> at =
                        lower ? std::array<std::array<int, 2>, 3>{{{1, 0}, {1, 1}, {0, 1}}}
                              : std::array<std::array<int, 2>, 3>{{{0, 0}, {1, 0}, {0, 1}}};
                    const double third = lower ? 2 / 3.0 : 1 / 3.0;
                    const int of_surface = surface(column + third, row + third);
                    if (of_surface == 2) continue;
                    std::array<TileCorner, 3> corners;
                    for (std::size_t k = 0; k < 3; ++k)
                        corners[k] = corner(column + at[k][0], row + at[k][1], of_surface);
                    for (std::size_t k = 0; k < 3; ++k) edges[{corners[k], corners[(k + 1) % 3]}] = own;
                    if (!own) continue;
                    Triangle triangle{};
                    for (std::size_t k = 0; k < 3; ++k) {
                        const auto [known, is_new] =
                            numbers.try_emplace(corners[k], static_cast<std::uint32_t>(mesh.corners.size()));
                        if (is_new) mesh.corners.push_back(corners[k]);
                        triangle[k] = known->second;
                    }
                    mesh.triangles.push_back(triangle);
                }
            }
        for (const auto& [edge, own] : edges) {
            const auto other = edges.find({edge[1], edge[0]});
            if (own && other != edges.end() && !other->second) mesh.seam_edges.push_back(edge);
        }
        return mesh;
    }
    std::vector<TileMesh> block(int i, int j, int side) const {
        std::vector<TileMesh> found;
        for (int row = j; row < j + side; ++row)
            for (int column = i; column < i + side; ++column) found.push_back(tile(column, row));
        return found;
    }

  private:
    TileCorner corner(int column, int row, int of_surface) const {
        const auto off = [&](std::uint32_t k, int at) {
            if (at == 0 || at == cells()) return 0;
            return static_cast<int>(1000 * (testing_mesher::uniform(k, column, row) - 0.5f));
        };
        constexpr int kStep = kCell_px * kPlacesPerPixel;
        return {{column * kStep + off(1, column), row * kStep + off(2, row)},
                disparity(column, row, of_surface)};
    }
};

CoarserTile coarser(const std::vector<TileMesh>& children, double share = 0.25) {
    std::vector<TileMesh> parts;
    for (const TileMesh& child : children) parts.push_back(simplified_alone(child, share));
    return coarser_tile(children, parts, share, [](double disparity) { return 100 / disparity; });
}

using PlacedEdge = std::array<TileCorner, 2>;

std::vector<PlacedEdge> edges_of(const TileMesh& mesh) {
    std::vector<PlacedEdge> edges;
    for (const Triangle& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k)
            edges.push_back({mesh.corners[t[k]], mesh.corners[t[(k + 1) % 3]]});
    std::sort(edges.begin(), edges.end());
    return edges;
}

std::size_t triangles_of(const std::vector<TileMesh>& tiles) {
    std::size_t count = 0;
    for (const TileMesh& tile : tiles) count += tile.triangles.size();
    return count;
}

double area_px2(const TileMesh& mesh) {
    double area = 0;
    for (const Triangle& t : mesh.triangles)
        area += 0.5 *
                static_cast<double>(twice_area(mesh.corners[t[0]].place, mesh.corners[t[1]].place,
                                               mesh.corners[t[2]].place)) /
                (double{1} * kPlacesPerPixel * kPlacesPerPixel);
    return area;
}

void expect_sound(const CoarserTile& tile, const std::vector<TileMesh>& children) {
    std::set<TileCorner> known;
    std::set<PlacedEdge> outwards;
    for (const TileMesh& child : children) {
        known.insert(child.corners.begin(), child.corners.end());
        outwards.insert(child.seam_edges.begin(), child.seam_edges.end());
    }
    std::erase_if(outwards, [all = outwards](const PlacedEdge& e) { return all.contains({e[1], e[0]}); });
    for (const Triangle& t : tile.mesh.triangles)
        EXPECT_GT(twice_area(tile.mesh.corners[t[0]].place, tile.mesh.corners[t[1]].place,
                             tile.mesh.corners[t[2]].place),
                  0);
    for (const TileCorner& corner : tile.mesh.corners) EXPECT_TRUE(known.contains(corner));
    const std::vector<PlacedEdge> edges = edges_of(tile.mesh);
    EXPECT_EQ(std::adjacent_find(edges.begin(), edges.end()), edges.end()) << "an edge is there twice";
    EXPECT_EQ((std::set<PlacedEdge>(tile.mesh.seam_edges.begin(), tile.mesh.seam_edges.end())), outwards);
    for (const PlacedEdge& edge : tile.mesh.seam_edges)
        EXPECT_TRUE(std::binary_search(edges.begin(), edges.end(), edge)) << "a crack";
}

TEST(LevelsOfDetail, HaveAQuarterOfTheTriangles) {
    for (const bool discs : {false, true}) {
        const std::vector<TileMesh> children = MadeUpRelief{2, discs}.block(0, 0, 2);
        const CoarserTile tile = coarser(children);
        expect_sound(tile, children);
        EXPECT_TRUE(tile.mesh.seam_edges.empty()) << "nothing is around them";
        EXPECT_LE(tile.mesh.triangles.size(), triangles_of(children) / 4 + 1);
        double area = 0;
        for (const TileMesh& child : children) area += area_px2(child);
        EXPECT_NEAR(area_px2(tile.mesh), area, 0.01 * area) << "silhouettes stay";
        EXPECT_GT(tile.error_px, 0);
        EXPECT_LT(tile.error_px, 0.5);
    }
}

// Four levels of one map: 4 x 4 tiles, their 2 x 2 coarser ones, and the one above.
TEST(LevelsOfDetail, FitNeighboursOfEveryLevel) {
    const MadeUpRelief relief{4, true};
    std::vector<std::vector<TileMesh>> fine, coarse;
    std::vector<TileMesh> of_two;
    for (int j = 0; j < 2; ++j)
        for (int i = 0; i < 2; ++i) {
            fine.push_back(relief.block(2 * i, 2 * j, 2));
            const CoarserTile tile = coarser(fine.back());
            expect_sound(tile, fine.back());
            EXPECT_FALSE(tile.mesh.seam_edges.empty());
            EXPECT_LE(tile.mesh.triangles.size(), triangles_of(fine.back()) / 4 + 1);
            coarse.push_back({tile.mesh});
            of_two.push_back(tile.mesh);
        }
    for (const unsigned levels : {1u, 6u, 9u, 14u, 15u}) {  // bits: which of the four are coarse
        std::vector<TileMesh> shown;
        for (unsigned k = 0; k < 4; ++k) {
            const auto& part = levels >> k & 1 ? coarse[k] : fine[k];
            shown.insert(shown.end(), part.begin(), part.end());
        }
        std::set<PlacedEdge> seams;
        std::vector<PlacedEdge> edges;
        for (const TileMesh& mesh : shown) {
            const auto own = edges_of(mesh);
            edges.insert(edges.end(), own.begin(), own.end());
            seams.insert(mesh.seam_edges.begin(), mesh.seam_edges.end());
        }
        std::sort(edges.begin(), edges.end());
        EXPECT_EQ(std::adjacent_find(edges.begin(), edges.end()), edges.end());
        for (const auto& [a, b] : seams) EXPECT_TRUE((seams.contains({b, a}))) << "a crack";
    }
    const CoarserTile root = coarser(of_two);
    expect_sound(root, of_two);
    EXPECT_TRUE(root.mesh.seam_edges.empty());
    EXPECT_LE(root.mesh.triangles.size(), triangles_of(of_two) / 4 + 1);
}

TEST(LevelsOfDetail, AreTheSameEachTime) {
    const std::vector<TileMesh> children = MadeUpRelief{}.block(0, 0, 2);
    const CoarserTile one = coarser(children), two = coarser(children);
    EXPECT_EQ(one.mesh.corners, two.mesh.corners);
    EXPECT_EQ(one.mesh.triangles, two.mesh.triangles);
    EXPECT_EQ(one.error_px, two.error_px);
}

TEST(LevelsOfDetail, OfNothingAreNothing) {
    EXPECT_TRUE(coarser({}).mesh.empty());
    EXPECT_TRUE(coarser({TileMesh{}, TileMesh{}}).mesh.empty());
    const std::vector<TileMesh> one = MadeUpRelief{}.block(0, 0, 1);
    const CoarserTile tile = coarser({one[0], TileMesh{}});
    expect_sound(tile, one);
    EXPECT_LE(tile.mesh.triangles.size(), one[0].triangles.size() / 4 + 1);
}

TEST(LevelsOfDetail, OfOneTriangleAreThatOne) {
    const TileCorner a{{0, 0}, 1}, b{{4096, 0}, 2}, c{{0, 4096}, 3};
    for (const bool at_seam : {false, true}) {
        TileMesh one{{a, b, c}, {{0, 1, 2}}, {}};
        if (at_seam) one.seam_edges = {{a, b}};
        const CoarserTile tile = coarser({one});
        expect_sound(tile, {one});
        EXPECT_EQ(tile.mesh.triangles.size(), 1u);
        EXPECT_EQ(tile.error_px, 0);
    }
}

// Two triangles that touch in a corner only, and one without area.
TEST(LevelsOfDetail, MayHaveVerticesOfSeveralFans) {
    const TileMesh mesh{
        {{{0, 0}, 1}, {{4096, 0}, 1}, {{0, 4096}, 1}, {{-4096, 0}, 1}, {{0, -4096}, 1}, {{8192, 0}, 1}},
        {{0, 1, 2}, {0, 3, 4}, {0, 1, 5}},
        {}};
    const CoarserTile tile = coarser({mesh}, 1);
    EXPECT_EQ(tile.mesh.triangles.size(), 2u);
    expect_sound(tile, {mesh});
}

}  // namespace
}  // namespace hexrelief::mesh_tiles::testing_levels
