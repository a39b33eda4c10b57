// Tests that strips along the rim of a near thing join it.
#include "pipeline/stages/by_colour/rim_strips.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace hexrelief::stages {
namespace {

constexpr int kMapWidth = 600,
              kMapHeight = 60;  // strips are at most 5 px wide, and rise by more than 1.33 px
constexpr int kThingBegin = 20, kThingEnd = 40;  // of a thing's rows and columns
constexpr float kThing_px = 60, kWallBehind_px = 20;

// A thing before a wall, which within some pixels of its border is farther.
DisparityMap thing_with_rim(int rim_px, float farther_px) {
    DisparityMap map{kMapWidth, kMapHeight, {}};
    for (int y = 0; y < kMapHeight; ++y)
        for (int x = 0; x < kMapWidth; ++x) {
            const int inside = std::min(std::min(x - kThingBegin, kThingEnd - 1 - x),
                                        std::min(y - kThingBegin, kThingEnd - 1 - y));
            map.values.push_back(inside < 0        ? kWallBehind_px
                                 : inside < rim_px ? kThing_px - farther_px
                                                   : kThing_px);
        }
    return map;
}

TEST(RimStrips, ContinueTheThingOnAllItsSides) {
    for (const int rim_px : {1, 4}) {
        const DisparityMap joined = with_rim_strips_joined(thing_with_rim(rim_px, 12));
        EXPECT_EQ(joined.values, thing_with_rim(0, 0).values) << rim_px;
    }
}

TEST(RimStrips, StayIfTheyAreWideOrLowOrNearerToWhatIsBehind) {
    for (const DisparityMap& map :
         {thing_with_rim(6, 12), thing_with_rim(3, 1.2f), thing_with_rim(3, 21), thing_with_rim(3, -12)})
        EXPECT_EQ(with_rim_strips_joined(map).values, map.values) << map.at(kThingBegin, 30);
}

TEST(RimStrips, StayIfTheyStandInFrontOfAGroove) {
    DisparityMap map = thing_with_rim(2, 10);
    const DisparityMap border = thing_with_rim(1, 4);
    for (std::size_t i = 0; i < map.values.size(); ++i)
        if (border.values[i] == kThing_px - 4) map.values[i] = border.values[i];
    EXPECT_EQ(with_rim_strips_joined(map).values, map.values);
}

TEST(RimStrips, LowOnesJoinWithHigherOnesBesideThem) {
    DisparityMap map = thing_with_rim(3, 1.2f);
    map.at(kThingBegin, 30) = kThing_px - 5;
    const DisparityMap joined = with_rim_strips_joined(map);
    EXPECT_EQ(joined.at(kThingBegin + 1, 25), kThing_px);
    EXPECT_EQ(joined.at(kThingEnd - 2, 30), kThing_px - 1.2f);
}

TEST(RimStrips, FollowWhatTheyContinue) {
    DisparityMap map = thing_with_rim(1, 12);
    map.at(kThingBegin + 1, 30) = kThing_px + 0.8f;
    const DisparityMap joined = with_rim_strips_joined(map);
    EXPECT_EQ(joined.at(kThingBegin, 30), kThing_px + 0.8f);
    EXPECT_EQ(joined.at(kThingBegin, 31), kThing_px);
}

TEST(RimStrips, SlopesAndUnknownPixelsStay) {
    DisparityMap map = thing_with_rim(0, 0);
    for (int y = kThingBegin; y < kThingEnd; ++y) {
        for (int x = kThingBegin; x < kThingBegin + 10; ++x)
            map.at(x, y) -= 0.9f * static_cast<float>(kThingBegin + 10 - x);
        map.at(kThingEnd, y) = map.at(kThingEnd - 3, y) = kUnknownDisparity;
    }
    for (int x = 100; x < 105; ++x) map.at(x, 5) = kUnknownDisparity;
    EXPECT_EQ(with_rim_strips_joined(map).values, map.values);
}

}  // namespace
}  // namespace hexrelief::stages
