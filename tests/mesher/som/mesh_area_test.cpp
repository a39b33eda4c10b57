// Tests the part of the image that the lattice covers.
#include "mesher/som/level_plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "pipeline/data/error.h"
#include "tests/mesher/densities.h"

namespace hexrelief::som {
namespace {

using namespace testing_mesher;

DensityMap empty(int width, int height) {
    return flat_density(width, height, 0);
}

void fill(DensityMap& density, int left, int top, int right, int bottom) {
    for (int y = top; y < bottom; ++y)
        for (int x = left; x < right; ++x)
            density.values[static_cast<std::size_t>(y) * density.width + x] = 1;
}

void expect_area(const MeshArea& area, int x, int y, int width, int height) {
    EXPECT_EQ(area.x, x);
    EXPECT_EQ(area.y, y);
    EXPECT_EQ(area.width, width);
    EXPECT_EQ(area.height, height);
}

TEST(MeshArea, IsTheImageWhereNothingIsLeftOut) {
    MeshConfig config;
    for (const MeshBorder border : {MeshBorder::fit, MeshBorder::slide, MeshBorder::free}) {
        config.border = border;
        expect_area(mesh_area(flat_density(90, 70), config), 0, 0, 90, 70);
        expect_area(mesh_area(empty(90, 70), config), 0, 0, 90, 70);
    }
    DensityMap density = empty(90, 70);
    fill(density, 20, 20, 60, 50);
    config.border = MeshBorder::slide;
    expect_area(mesh_area(density, config), 0, 0, 90, 70);
    config.border = MeshBorder::free;
    expect_area(mesh_area(density, config), 0, 0, 90, 70);
}

TEST(MeshArea, IsTheSmallestRectangle) {
    std::mt19937 random(5);
    const auto pick = [&](int low, int high) {
        return low + static_cast<int>(random() % static_cast<unsigned>(high - low + 1));
    };
    for (int k = 0; k < 200; ++k) {
        DensityMap density = empty(200, 150);
        const int left = pick(0, 60), right = pick(140, 200), top = pick(0, 40), bottom = pick(110, 150);
        // one pixel on each side, at a place that the searches for the other sides do not reach
        fill(density, left, pick(top, bottom - 1), left + 1, bottom);
        fill(density, right - 1, top, right, pick(top, bottom - 1) + 1);
        fill(density, pick(left, right - 1), top, right, top + 1);
        fill(density, left, bottom - 1, pick(left, right - 1) + 1, bottom);
        expect_area(mesh_area(density, {}), left, top, right - left, bottom - top);
    }
}

TEST(MeshArea, HoldsAPixelAVertexAndIsNotStretched) {
    DensityMap density = empty(300, 240);
    fill(density, 299, 3, 300, 4);
    expect_area(mesh_area(density, {}), 250, 0, 50, 40);
    density = empty(300, 240);
    fill(density, 0, 100, 300, 110);  // 6 px a column, so at least 3 a row
    expect_area(mesh_area(density, {}), 0, 45, 300, 120);
    density = empty(300, 240);
    fill(density, 40, 0, 60, 240);
    expect_area(mesh_area(density, {}), 0, 0, 150, 240);
    density = empty(19, 18);
    fill(density, 18, 17, 19, 18);
    EXPECT_LE(mesh_area(density, {}).width, 19);
}

TEST(MeshArea, BordersBendAlikeInAMirror) {
    DensityMap density = flat_density(240, 160), mirrored = density;
    for (int y = 0; y < 60; ++y)
        for (int x = 50; x < 130; ++x) density.values[y * 240 + x] = mirrored.values[y * 240 + 239 - x] = 0;
    MeshConfig config{.balance = {.enabled = true}};
    const MeshArea area = mesh_area(density, config);
    const std::vector<float> upper = mesh_outline(density, area, config).upper;
    std::vector<float> back = mesh_outline(mirrored, area, config).upper;
    std::reverse(back.begin(), back.end());
    ASSERT_EQ(upper.size(), 241);
    EXPECT_GT(*std::max_element(upper.begin(), upper.end()), 5);
    for (std::size_t x = 0; x < upper.size(); ++x) EXPECT_NEAR(upper[x], back[x], 1e-3) << x;
}

TEST(MeshArea, CutsTheDensity) {
    const DensityMap density = noise_density(40, 30, 3);
    const std::vector<float> part = density_within(density, {7, 5, 20, 11});
    ASSERT_EQ(part.size(), 220u);
    for (int y = 0; y < 11; ++y)
        for (int x = 0; x < 20; ++x) EXPECT_EQ(part[y * 20 + x], density.at(7 + x, 5 + y));
}

// The result does not depend on the position in the image.
TEST(MeshArea, MeshesMoveWithWhatTheyCover) {
    const DensityMap bumps = bumps_density(120, 100);
    const auto mesh_at = [&](int left, int top) {
        DensityMap density = empty(240, 200);
        for (int y = 0; y < 100; ++y)
            for (int x = 0; x < 120; ++x)
                density.values[static_cast<std::size_t>(top + y) * 240 + left + x] = 0.01f + bumps.at(x, y);
        return solve(density, {});
    };
    const HexMesh2D here = mesh_at(0, 0), there = mesh_at(64, 32);
    EXPECT_EQ(here.columns, 40);
    EXPECT_EQ(here.rows, 33);
    for (std::size_t i = 0; i < here.positions.size(); ++i) {
        EXPECT_NEAR(there.positions[i].x - 64, here.positions[i].x, 1e-4);
        EXPECT_NEAR(there.positions[i].y - 32, here.positions[i].y, 1e-4);
    }
    for (int row = 0; row < there.rows; ++row) {
        EXPECT_EQ(there.at(0, row).x, 64);
        EXPECT_EQ(there.at(there.columns - 1, row).x, 184);
    }
    for (int column = 0; column < there.columns; ++column) {
        EXPECT_EQ(there.at(column, 0).y, 32);
        EXPECT_EQ(there.at(column, there.rows - 1).y, 132);
    }
}

// Nothing draws it anywhere, so it is what a density of 0 leaves.
TEST(RegularMesh, IsThatOfAnEmptyDensityOverTheWholeImage) {
    for (const MeshBorder border : {MeshBorder::fit, MeshBorder::free}) {
        const MeshConfig config{.spacing_px = 7, .border = border};
        const HexMesh2D regular = mesher::regular_mesh(150, 110, config),
                        solved = solve(empty(150, 110), config);
        ASSERT_EQ(regular.columns, solved.columns);
        ASSERT_EQ(regular.rows, solved.rows);
        for (std::size_t i = 0; i < regular.positions.size() && border == MeshBorder::fit; ++i) {
            EXPECT_NEAR(regular.positions[i].x, solved.positions[i].x, 1) << i;
            EXPECT_NEAR(regular.positions[i].y, solved.positions[i].y, 1) << i;
        }
        EXPECT_EQ(regular.at(0, 0).x, 0);
        EXPECT_EQ(regular.at(regular.columns - 1, regular.rows - 1).x, 150);
        EXPECT_EQ(regular.at(regular.columns - 1, regular.rows - 1).y, 110);
    }
    EXPECT_THROW(mesher::regular_mesh(20, 110, {.spacing_px = 7}), Error);
}

}  // namespace
}  // namespace hexrelief::som
