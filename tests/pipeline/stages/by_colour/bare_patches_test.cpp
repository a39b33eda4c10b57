// Tests that bare patches follow the farther surface that their colours lead to.
#include "pipeline/stages/by_colour/bare_patches.h"

#include <gtest/gtest.h>

namespace hexrelief::stages {
namespace {

constexpr int kRoomWidth = 60, kRoomHeight = 40;
constexpr int kWall = 24, kFoot = 8;  // columns that the wall begins at, rows of it that matched
constexpr float kHead_px = 40, kWall_px = 4;

// A matched head on the left, and a bare wall on the right that matched at its foot only, and was filled from
// the head.
struct Room {
    DisparityMap map{kRoomWidth, kRoomHeight, {}, {}};
    Image left{kRoomWidth, kRoomHeight, 3, {}};

    explicit Room(int wall_level) {
        for (int y = 0; y < kRoomHeight; ++y)
            for (int x = 0; x < kRoomWidth; ++x) {
                const bool is_head = x < kWall, is_foot = !is_head && y >= kRoomHeight - kFoot;
                map.values.push_back(is_foot ? kWall_px : kHead_px);
                map.origins.push_back(is_head || is_foot ? PixelOrigin::matched : PixelOrigin::filled);
                for (int c = 0; c < 3; ++c)
                    left.pixels.push_back(static_cast<std::uint8_t>(is_head ? 200 : wall_level));
            }
    }
};

TEST(BarePatches, FollowTheFartherSurfaceOfTheirColour) {
    const Room room(90);
    const DisparityMap result = with_bare_patches_behind(room.map, room.left, 2);
    for (int y = 0; y < kRoomHeight; ++y)
        for (int x = 0; x < kRoomWidth; ++x) {
            if (x >= kWall - 2 && x < kWall + 2) continue;  // squares of both colours
            EXPECT_EQ(result.at(x, y), x < kWall ? kHead_px : kWall_px) << x << ", " << y;
        }
    EXPECT_EQ(result.origins, room.map.origins);
}

TEST(BarePatches, OfTheNearerSurfacesColourStay) {
    const Room room(200);
    const DisparityMap result = with_bare_patches_behind(room.map, room.left, 2);
    EXPECT_EQ(result.at(kWall + 3, 2), kHead_px);
}

TEST(BarePatches, UnknownPixelsAndMapsWithoutOriginsStay) {
    Room room(90);
    room.map.at(kRoomWidth - 1, 0) = kUnknownDisparity;
    EXPECT_EQ(with_bare_patches_behind(room.map, room.left, 2).at(kRoomWidth - 1, 0), kUnknownDisparity);
    room.map.origins.clear();
    EXPECT_EQ(with_bare_patches_behind(room.map, room.left, 2).values, room.map.values);
}

}  // namespace
}  // namespace hexrelief::stages
