// Tests tiles that are solved separately: they make one lattice, and together the triangles of the undivided
// surface, to the bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "mesher/mesher.h"
#include "mesher/tiles/tile_surface.h"
#include "pipeline/stages/density.h"
#include "tests/mesher/busy_map.h"

namespace hexrelief::mesh_tiles {
namespace {

using namespace testing_mesher;

DensityMap halved(const DensityMap& fine) {
    DensityMap coarse{(fine.width + 1) / 2, (fine.height + 1) / 2, {}, fine.background_px};
    coarse.values.resize(static_cast<std::size_t>(coarse.width) * coarse.height);
    for (int y = 0; y < fine.height; ++y)
        for (int x = 0; x < fine.width; ++x)
            coarse.values[static_cast<std::size_t>(y / 2) * coarse.width + x / 2] += fine.at(x, y);
    return coarse;
}

template <typename Values>
Values part_of(const Values& values, int whole_width, int channels, const MapRect& w) {
    Values part;
    for (int y = w.y; y < w.y + w.height; ++y) {
        const auto row = values.begin() + channels * (static_cast<std::ptrdiff_t>(y) * whole_width + w.x);
        part.insert(part.end(), row, row + static_cast<std::ptrdiff_t>(channels) * w.width);
    }
    return part;
}

// A map in tiles, and undivided.
class Tiled {
  public:
    Tiled(DisparityMap disparities, double spacing_px, int tile, int threads)
        : map(std::move(disparities)), threads_(threads) {
        rounded_disparities(map);
        config.spacing_px = spacing_px;
        density = stages::compute_density(map, stages::DensityConfig{});
        undivided = mesher::solve_mesh(density, config, threads, {});
        coarse_ = {mesher::solve_mesh(halved(density), config, threads, {}), 2, map.width, map.height};
        tiling.emplace(undivided.columns, undivided.rows, tile);
    }
    TileSolver solver() const { return {*tiling, coarse_, config.balance, density_of_, threads_}; }

    // Returns the blocks by (i, j); backwards: solves the last one first.
    std::map<std::pair<int, int>, LatticeBlock> solve(bool backwards) const {
        const TileSolver tiles = solver();
        std::vector<Seam> row_seams(static_cast<std::size_t>(tiling->down()) + 1);
        for (int j = 1; j < tiling->down(); ++j) row_seams[j] = tiles.row_seam(j);
        std::map<std::pair<int, int>, Seam> column_seams;
        std::map<std::pair<int, int>, LatticeBlock> blocks;
        const auto row_seam = [&](int j) { return j > 0 && j < tiling->down() ? &row_seams[j] : nullptr; };
        std::vector<std::pair<int, int>> order;
        for (int j = 0; j < tiling->down(); ++j)
            for (int i = 0; i < tiling->across(); ++i) {
                order.push_back({i, j});
                if (i > 0) column_seams[{i, j}] = tiles.column_seam(i, j, row_seam(j), row_seam(j + 1));
            }
        if (backwards) std::reverse(order.begin(), order.end());
        const auto column_seam = [&](int i, int j) {
            return column_seams.contains({i, j}) ? &column_seams.at({i, j}) : nullptr;
        };
        for (const auto& [i, j] : order)
            blocks[{i, j}] =
                tiles.tile(i, j, {row_seam(j), row_seam(j + 1), column_seam(i, j), column_seam(i + 1, j)});
        return blocks;
    }
    HexMesh2D assembled(const std::map<std::pair<int, int>, LatticeBlock>& blocks) const {
        HexMesh2D mesh = undivided;
        for (const auto& [tile, block] : blocks)
            for (int row = block.first_row; row < block.end_row(); ++row)
                for (int column = block.first_column; column < block.end_column(); ++column)
                    mesh.positions[mesh.index(column, row)] =
                        in_window(block.at(column, row), {0, 0, map.width, map.height});
        return mesh;
    }
    surface::WholeMap whole() const {
        surface::WholeMap found;
        found.cell_px =
            static_cast<double>(map.values.size()) / static_cast<double>(undivided.positions.size());
        for (const float d : map.values) {
            if (!DisparityMap::known(d) || !(d > 0)) continue;
            found.nearest_px = std::max(found.nearest_px, d);
            found.farthest_px = found.farthest_px > 0 ? std::min(found.farthest_px, d) : d;
        }
        return found;
    }
    TileSurface surface(int i, int j, const LatticeBlock& block) const {
        const MapRect window = window_of(block, kTileMargin_px, map.width, map.height);
        const DisparityMap part{window.width, window.height, part_of(map.values, map.width, 1, window)};
        return cut_tile(*tiling, i, j, block, {window, &part, density.background_px, whole()},
                        SurfaceConfig{}, threads_);
    }

    DisparityMap map;
    DensityMap density;
    MeshConfig config;
    HexMesh2D undivided;
    std::optional<LatticeTiling> tiling;

  private:
    CoarseLattice coarse_;
    int threads_;
    DensityOfWindow density_of_ = [this](const MapRect& w) {
        return DensityMap{w.width, w.height, part_of(density.values, map.width, 1, w), density.background_px};
    };
};

using PlacedTriangle = std::array<TileCorner, 3>;

std::vector<PlacedTriangle> placed(const DisparityMesh& mesh, const MapRect& window) {
    std::vector<PlacedTriangle> found;
    for (const Triangle& t : mesh.triangles) {
        PlacedTriangle corners;
        for (std::size_t k = 0; k < 3; ++k)
            corners[k] = {place_of(mesh.points[t[k]], window), mesh.disparities[t[k]]};
        std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
        found.push_back(corners);
    }
    return found;
}

TEST(LatticeTiling, CoversTheLattice) {
    for (const int columns : {3, 65, 66, 99, 100, 131, 140, 400, 1001})
        for (const int spacings : {1, 66, 100, 512}) {
            const LatticeTiling tiling(columns, 70, spacings);
            EXPECT_EQ(tiling.column_of(0), 0);
            EXPECT_EQ(tiling.column_of(tiling.across()), columns - 1);
            for (int i = 1; i < tiling.across(); ++i) {
                EXPECT_EQ(tiling.column_of(i) % 6, 0);
                EXPECT_GE(tiling.column_of(i + 1) - tiling.column_of(i), LatticeTiling::kLeastTile / 2);
            }
        }
}

constexpr int kSide_px = 372, kTile = 78;  // 124 x 124 vertices in 2 x 2 tiles
constexpr double kSpacing_px = 3;

const Tiled& made_up(std::uint32_t seed) {
    static std::map<std::uint32_t, Tiled> solved;
    return solved.try_emplace(seed, busy_map(kSide_px, kSide_px, seed), kSpacing_px, kTile, 2).first->second;
}

TEST(TilesInAnyOrder, AndOnAnyNumberOfThreadsAreTheSame) {
    const Tiled one(busy_map(kSide_px, kSide_px, 1), kSpacing_px, kTile, 1);
    ASSERT_EQ(one.tiling->across() * one.tiling->down(), 4);
    const auto forwards = one.solve(false), backwards = made_up(1).solve(true);
    for (const auto& [tile, block] : forwards) EXPECT_EQ(block.places, backwards.at(tile).places);
}

TEST(TilesInBalance, AsTheUndividedLatticeIs) {
    for (const std::uint32_t seed : {1u, 2u}) {
        const Tiled& tiled = made_up(seed);
        const quality::MeshQuality whole = quality::measure_quality(tiled.undivided, tiled.density, 2),
                                   tiles = quality::measure_quality(tiled.assembled(tiled.solve(false)),
                                                                    tiled.density, 2);
        EXPECT_LT(tiles.percent_cost, whole.percent_cost + 0.5);
        EXPECT_EQ(tiles.inverted_triangles, 0);
        EXPECT_GT(tiles.percentile1_angle_deg, whole.percentile1_angle_deg - 1);
    }
}

// Returns the number of triangles.
std::size_t expect_undivided_surface(const Tiled& tiled) {
    const auto blocks = tiled.solve(false);
    const HexMesh2D lattice = tiled.assembled(blocks);
    std::vector<PlacedTriangle> expected =
        placed(surface::cut_disparity_mesh({&lattice, &tiled.map, tiled.density.background_px, tiled.whole()},
                                           SurfaceConfig{}, 2),
               {});
    std::vector<PlacedTriangle> found;
    std::set<std::array<TileCorner, 2>> seam_edges;
    std::size_t seams = 0;
    for (const auto& [tile, block] : blocks) {
        const TileSurface surface = tiled.surface(tile.first, tile.second, block);
        const auto own =
            placed(surface.mesh, window_of(block, kTileMargin_px, tiled.map.width, tiled.map.height));
        found.insert(found.end(), own.begin(), own.end());
        seam_edges.insert(surface.seam_edges.begin(), surface.seam_edges.end());
        seams += surface.seam_edges.size();
    }
    std::sort(expected.begin(), expected.end());
    std::sort(found.begin(), found.end());
    EXPECT_TRUE(found == expected) << found.size() << " in tiles, " << expected.size() << " in the whole";
    EXPECT_EQ(seam_edges.size(), seams) << "an edge is one tile's";
    for (const auto& [a, b] : seam_edges) EXPECT_TRUE((seam_edges.contains({b, a}))) << "no crack";
    return found.size();
}

TEST(Tiles, TogetherHaveTheTrianglesOfTheUndividedSurface) {
    EXPECT_GT(expect_undivided_surface(made_up(1)), 20000u);
}

TEST(Tiles, MayHaveNothingInThem) {
    DisparityMap map = busy_map(kSide_px, kSide_px, 2);
    // the remaining density is in the corners: the lattice covers the whole map
    for (int y = 0; y < kSide_px; ++y)
        for (int x = 0; x < kSide_px; ++x)
            if ((x < kSide_px / 2 + 60) != (y < kSide_px / 2 + 60))
                map.values[static_cast<std::size_t>(y) * kSide_px + x] = kUnknownDisparity;
    EXPECT_GT(expect_undivided_surface({map, kSpacing_px, kTile, 2}), 5000u);
}

}  // namespace
}  // namespace hexrelief::mesh_tiles
