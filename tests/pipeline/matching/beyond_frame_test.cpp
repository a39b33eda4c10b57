#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "pipeline/matching/matcher.h"

namespace hexrelief::matching {
namespace {

constexpr int kWidth = 100, kHeight = 20, kMin_px = 4, kStrip_px = 24;

// A map of one surface whose pixels left of kStrip_px have no match and the disparity of the strip's edge.
template <typename Surface>
MatchedMap map_of(const Surface& surface) {
    MatchedMap map{kWidth, kHeight, {}, {}};
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            const double disparity_px = surface(std::max(x, kStrip_px));
            map.disparities.push_back(static_cast<std::int16_t>(std::lround(kOnePixel * disparity_px)));
            map.is_matched.push_back(x >= kStrip_px);
        }
    return map;
}

double disparity_px(const MatchedMap& map, int x, int y) {
    return map.disparities[static_cast<std::size_t>(y) * kWidth + x] / double{kOnePixel};
}

TEST(BeyondFrame, PlanesGoOn) {
    for (const double slope : {-0.5, -0.1, 0.0, 0.2}) {
        const auto plane = [&](int x) { return 30 + slope * (x - kStrip_px); };
        MatchedMap map = map_of(plane);
        continue_beyond_frame(map, kMin_px);
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kWidth; ++x) EXPECT_NEAR(disparity_px(map, x, y), plane(x), 0.1) << x;
    }
}

TEST(BeyondFrame, RoundSurfacesFlatten) {
    const auto round = [](int x) { return 40 - 0.004 * (x - 10) * (x - 10); };
    MatchedMap map = map_of(round);
    continue_beyond_frame(map, kMin_px);
    for (int x = 10; x < kStrip_px; ++x) EXPECT_NEAR(disparity_px(map, x, 5), round(x), 0.15) << x;
    for (int x = 0; x < 10; ++x) EXPECT_NEAR(disparity_px(map, x, 5), 40, 0.15) << x;
}

TEST(BeyondFrame, RidgesAndOtherSurfacesStay) {
    const auto ridge = [](int x) { return 40 - 0.3 * std::abs(x - 36); };
    const auto step = [](int x) { return x < kStrip_px + 6 ? 40 : 30 + 0.3 * x; };
    const MatchedMap before[] = {map_of(ridge), map_of(step)};
    for (MatchedMap map : before) {
        const MatchedMap unchanged = map;
        continue_beyond_frame(map, kMin_px);
        EXPECT_EQ(map.disparities, unchanged.disparities);
    }
}

TEST(BeyondFrame, WhatTheRightCameraSeesStays) {
    MatchedMap map =
        map_of([](int x) { return 10 + 0.2 * (x - kStrip_px); });  // filled, but within the frame
    const MatchedMap unchanged = map;
    continue_beyond_frame(map, kMin_px);
    for (int x = 14; x < kWidth; ++x)
        EXPECT_EQ(map.disparities[static_cast<std::size_t>(x)],
                  unchanged.disparities[static_cast<std::size_t>(x)]);
}

}  // namespace
}  // namespace hexrelief::matching
