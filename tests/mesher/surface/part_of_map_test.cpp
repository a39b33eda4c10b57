// Tests that a part of a map, with the lattice there, is cut into the same triangles as the whole
// map, to the bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <set>

#include "mesher/mesher.h"
#include "tests/mesher/busy_map.h"
#include "tests/mesher/regular_lattice.h"

namespace hexrelief::surface {
namespace {

using namespace testing_mesher;

constexpr int kWide = 700, kHigh = 520, kSpacing = 7;
constexpr float kPlaces = 1024;  // positions per px

HexMesh2D jittered_lattice(std::uint32_t seed) {
    HexMesh2D mesh = mesher::regular_lattice(kWide, kHigh, kSpacing);
    std::uint32_t i = 0;
    for (Vec2f& p : mesh.positions) {
        p.x += 3 * (uniform(seed, i, 11) - 0.5f);
        p.y += 3 * (uniform(seed, i++, 12) - 0.5f);
        p = {std::round(std::clamp(p.x, 0.0f, 1.0f * kWide) * kPlaces) / kPlaces,
             std::round(std::clamp(p.y, 0.0f, 1.0f * kHigh) * kPlaces) / kPlaces};
    }
    return mesh;
}

struct Window {
    int x, y, width, height;                     // px
    int first_column, first_row, columns, rows;  // of the lattice
};

DisparityMap part_of(const DisparityMap& map, const Window& w) {
    DisparityMap part{w.width, w.height, {}};
    for (int y = w.y; y < w.y + w.height; ++y)
        part.values.insert(part.values.end(), &map.values[static_cast<std::size_t>(y) * map.width + w.x],
                           &map.values[static_cast<std::size_t>(y) * map.width + w.x] + w.width);
    return part;
}

HexMesh2D part_of(const HexMesh2D& mesh, const Window& w) {
    HexMesh2D part{w.columns, w.rows, {}};
    for (int row = 0; row < w.rows; ++row)
        for (int column = 0; column < w.columns; ++column) {
            const Vec2f p = mesh.positions[mesh.index(w.first_column + column, w.first_row + row)];
            part.positions.push_back({p.x - static_cast<float>(w.x), p.y - static_cast<float>(w.y)});
        }
    return part;
}

using PlacedTriangle = std::array<float, 9>;  // positions in the whole map, and disparities

// Returns the triangles whose corners all lie at least `px` px inside a window; the mesh's coordinates
// begin at (x, y).
std::set<PlacedTriangle> inner_triangles(const DisparityMesh& mesh, int x, int y, const Window& w, float px) {
    const Vec2f first{static_cast<float>(w.x) + px, static_cast<float>(w.y) + px},
        last{static_cast<float>(w.x + w.width) - px, static_cast<float>(w.y + w.height) - px};
    std::set<PlacedTriangle> found;
    for (const Triangle& t : mesh.triangles) {
        PlacedTriangle placed{};
        bool inside = true;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec2f p{mesh.points[t[k]].x + static_cast<float>(x),
                          mesh.points[t[k]].y + static_cast<float>(y)};
            inside &= p.x >= first.x && p.y >= first.y && p.x <= last.x && p.y <= last.y;
            placed[3 * k] = p.x, placed[3 * k + 1] = p.y, placed[3 * k + 2] = mesh.disparities[t[k]];
        }
        if (inside) found.insert(placed);
    }
    return found;
}

WholeMap whole_of(const DisparityMap& map, const HexMesh2D& lattice) {
    WholeMap whole{
        .cell_px = static_cast<double>(map.values.size()) / static_cast<double>(lattice.positions.size()),
        .columns = lattice.columns};
    for (const float d : map.values) {
        if (!std::isfinite(d)) continue;
        whole.nearest_px = std::max(whole.nearest_px, d);
        whole.farthest_px = whole.farthest_px > 0 ? std::min(whole.farthest_px, d) : d;
    }
    return whole;
}

class PartOfMap : public testing::TestWithParam<std::uint32_t> {};
INSTANTIATE_TEST_SUITE_P(Surface, PartOfMap, testing::Range(0u, 3u));

TEST_P(PartOfMap, SameTrianglesAsTheWhole) {
    constexpr int kBeyond_px = 24;  // px around the part's lattice
    const std::uint32_t seed = GetParam();
    const DisparityMap map = busy_map(kWide, kHigh, seed);
    const HexMesh2D lattice = jittered_lattice(seed);
    SurfaceConfig config{.silhouette_inset_px = seed % 2 ? 0.5 : 0};
    WholeMap whole = whole_of(map, lattice);
    const DisparityMesh all = cut_disparity_mesh({&lattice, &map, 10, whole}, config, 2);

    Window w{0, 0, 0, 0, 5 + static_cast<int>(seed % 12), 4 + 2 * static_cast<int>(seed % 3), 80, 62};
    const Vec2f first = lattice.positions[lattice.index(w.first_column, w.first_row)],
                last =
                    lattice
                        .positions[lattice.index(w.first_column + w.columns - 1, w.first_row + w.rows - 1)];
    w.x = static_cast<int>(first.x) - kBeyond_px, w.y = static_cast<int>(first.y) - kBeyond_px;
    w.width = static_cast<int>(last.x) + kBeyond_px - w.x,
    w.height = static_cast<int>(last.y) + kBeyond_px - w.y;
    whole.first_column = w.first_column, whole.first_row = w.first_row;
    const DisparityMap part_map = part_of(map, w);
    const HexMesh2D part_lattice = part_of(lattice, w);
    const DisparityMesh part = cut_disparity_mesh({&part_lattice, &part_map, 10, whole}, config, 2);

    const float px = kBeyond_px + 16.0f * kSpacing;
    const std::set<PlacedTriangle> expected = inner_triangles(all, 0, 0, w, px);
    EXPECT_GT(expected.size(), 1500u);
    EXPECT_EQ(inner_triangles(part, w.x, w.y, w, px), expected);
}

}  // namespace
}  // namespace hexrelief::surface
