#include "pipeline/stages/other_views/bridges.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "pipeline/stages/other_views/backing.h"
#include "pipeline/stages/other_views/small_regions.h"

namespace hexrelief::stages {
namespace {

constexpr int kWidth = 120, kHeight = 60, kReach_px = 40;
constexpr double kWall = 10, kPost = 30, kFar = 2;
constexpr std::size_t kLeast = 1000;

// A wall in front of which stands a post from column 48 to 71, and of which two pieces are missing beside it.
struct Scene {
    SeenSurface here{{0, 0, 0, 1, kWidth, kHeight}, Disparities(kWidth* kHeight, kWall)};
    OtherView view;

    explicit Scene(bool has_post) {
        view.place = here.place;
        view.missing = {kWidth, kHeight, std::vector<float>(kWidth * kHeight, kUnknownDisparity)};
        view.color = {kWidth, kHeight, 3, std::vector<std::uint8_t>(3 * kWidth * kHeight, 100)};
        if (has_post) fill_surface(48, 72, 0, kHeight, kPost);
        for (int y = 20; y < 40; ++y)
            for (const int x : {32, 72}) std::fill_n(&view.missing.at(x, y), 16, static_cast<float>(kWall));
    }
    void fill_surface(int left, int right, int top, int bottom, double d) {
        for (int y = top; y < bottom; ++y)
            std::fill(&here.disparities[y * kWidth + left], &here.disparities[y * kWidth + right], d);
    }
    void join(std::size_t least = kLeast, int reach_px = kReach_px) {
        paint_bridges(view, join_regions(view.missing, here, least, reach_px, kOneSurface_px));
    }
    bool is_joined() const {
        const auto known =
            std::count_if(view.missing.values.begin(), view.missing.values.end(), DisparityMap::known);
        return specks_of(view.missing, static_cast<std::size_t>(known), kOneSurface_px).empty();
    }
};

TEST(Bridges, JoinRegionsOnOneSurface) {
    Scene scene(false);
    ASSERT_FALSE(scene.is_joined());
    scene.join();
    EXPECT_TRUE(scene.is_joined());
    EXPECT_EQ(scene.view.missing.at(60, 2), kUnknownDisparity) << "far from the bridge";
}

TEST(Bridges, AreNotBuiltBetweenLargeRegionsOrFarOnes) {
    for (const auto& [least, reach_px] : {std::pair<std::size_t, int>{320, kReach_px}, {kLeast, 8}}) {
        Scene scene(false);
        const std::vector<float> before = scene.view.missing.values;
        scene.join(least, reach_px);
        EXPECT_EQ(scene.view.missing.values, before) << least << ", " << reach_px;
    }
}

TEST(Bridges, LeadOnBehindNearerThingsInTheColoursOfTheirBeginning) {
    Scene scene(true);
    for (int y = 0; y < kHeight; ++y) std::fill_n(scene.view.color.at(48, y), 3 * 24, std::uint8_t{200});
    scene.join();
    EXPECT_TRUE(scene.is_joined());
    int hidden = 0;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 48; x < 72; ++x) {
            const bool is_bridge = DisparityMap::known(scene.view.missing.at(x, y));
            hidden += is_bridge;
            EXPECT_EQ(scene.view.missing.at(x, y), is_bridge ? kWall : kUnknownDisparity) << x << ", " << y;
            EXPECT_EQ(scene.view.color.at(x, y)[0], is_bridge ? 100 : 200) << x << ", " << y;
        }
    EXPECT_GE(hidden, 24 * 7);
}

TEST(Bridges, LeadAroundNearerThingsWhereTheSurfaceDoes) {
    Scene scene(true);
    scene.fill_surface(48, 72, 40, kHeight, kWall);  // the post ends above the floor
    scene.join();
    EXPECT_TRUE(scene.is_joined());
    for (int x = 48; x < 72; ++x) EXPECT_EQ(scene.view.missing.at(x, 30), kUnknownDisparity) << x;
}

TEST(Bridges, KeepAwayFromWhereTheSurfaceEnds) {
    Scene scene(false);
    scene.fill_surface(48, 72, 0, 28, kFar);
    scene.fill_surface(48, 72, 34, kHeight, kFar);  // leaves 6 px
    scene.join();
    EXPECT_FALSE(scene.is_joined());
}

TEST(Bridges, RegionsThatDifferStayApart) {
    Scene scene(false);
    for (int x = 72; x < kWidth; ++x) scene.fill_surface(x, x + 1, 0, kHeight, kWall + 5);
    for (int y = 20; y < 40; ++y)
        std::fill_n(&scene.view.missing.at(72, y), 16, static_cast<float>(kWall + 5));
    scene.join();
    EXPECT_FALSE(scene.is_joined());
}

TEST(Bridges, JoinPartsOfABackingAlongItsSurface) {
    Scene scene(true);
    scene.view.map = {kWidth, kHeight, std::vector<float>(kWidth * kHeight, static_cast<float>(kWall))};
    join_backing(scene.view, kLeast, kReach_px);
    EXPECT_TRUE(scene.is_joined());
    scene = Scene(true);
    scene.view.map = {kWidth, kHeight, std::vector<float>(kWidth * kHeight, kUnknownDisparity)};
    join_backing(scene.view, kLeast, kReach_px);
    EXPECT_FALSE(scene.is_joined()) << "it has no surface there";
}

// The values of a floor 12 px wide under a wall that rises in steps of step_px, 3 rows each, once merged.
std::vector<float> merged_floor(double step_px, bool as_given) {
    DisparityMap map{12, 30, {}};
    for (int i = 0; i < 12 * 30; ++i)
        map.values.push_back(static_cast<float>(kWall + step_px * std::max(0, (i / 12 - 15) / 3)));
    if (!as_given) merge_specks(map);
    return map.values;
}

TEST(SmallRegions, AFloorThatRisesIsOneSurface) {
    EXPECT_EQ(merged_floor(2.5, false), merged_floor(2.5, true));
    EXPECT_EQ(merged_floor(3.5, false), merged_floor(0, true));  // each step is too small for a surface
}

}  // namespace
}  // namespace hexrelief::stages
