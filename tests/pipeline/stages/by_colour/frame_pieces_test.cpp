// Tests that small pieces at the left end of a map join what is beside them.
#include "pipeline/stages/by_colour/frame_pieces.h"

#include <gtest/gtest.h>

namespace hexrelief::stages {
namespace {

// Pieces are at most 24 px long and come within 6 px of the left end; steps are of 2.67 and 2 px.
constexpr int kMapColumns = 600, kMapRows = 200;
constexpr float kInside_px = 20;

struct Rectangle {
    int x, y, width, height;
};

DisparityMap inside() {
    const std::size_t count = std::size_t{kMapColumns} * kMapRows;
    return {kMapColumns, kMapRows, std::vector<float>(count, kInside_px),
            std::vector<PixelOrigin>(count, PixelOrigin::matched)};
}

// Sets a rectangle, of whose columns the first ones are filled, the others matched.
void put(DisparityMap& map, const Rectangle& at, float disparity_px, int filled_columns) {
    for (int y = at.y; y < at.y + at.height; ++y)
        for (int x = at.x; x < at.x + at.width; ++x) {
            map.at(x, y) = disparity_px;
            if (x < at.x + filled_columns)
                map.origins[static_cast<std::size_t>(y) * kMapColumns + x] = PixelOrigin::filled;
        }
}

DisparityMap with_piece(const Rectangle& at, float disparity_px, int filled_columns) {
    DisparityMap map = inside();
    put(map, at, disparity_px, filled_columns);
    return map;
}

TEST(FramePieces, JoinWhatIsBesideThem) {
    for (const DisparityMap& map : {
             with_piece({0, 90, 10, 20}, 40, 10),   // in front, short
             with_piece({0, 60, 20, 80}, 40, 20),   // in front, longer than it is wide
             with_piece({0, 0, 40, 20}, 40, 40),    // in a corner
             with_piece({5, 90, 100, 20}, 40, 70),  // long, mostly filled
             with_piece({0, 90, 100, 20}, 5, 30),   // behind, mostly matched
             with_piece({0, 95, 6, 6}, 5, 0),       // behind, small, all matched
         })
        EXPECT_EQ(with_frame_pieces_joined(map, 2).values, inside().values);
}

TEST(FramePieces, OthersStay) {
    DisparityMap without_origins = with_piece({0, 90, 10, 20}, 40, 10);
    without_origins.origins.clear();
    for (const DisparityMap& map : {
             without_origins,
             with_piece({0, 90, 30, 30}, 40, 30),                 // of a thing's size
             with_piece({0, 90, 100, 20}, 40, 60),                // in front, with matches
             with_piece({0, 90, 100, 20}, 5, 20),                 // behind, with more matches
             with_piece({0, 90, 100, 30}, 5, 100),                // behind, too high for a pit
             with_piece({6, 90, 10, 20}, 40, 10),                 // not at the left end
             with_piece({kMapColumns - 10, 90, 10, 20}, 40, 10),  // at the right end
             with_piece({0, 90, 10, 20}, kInside_px + 2.6f, 10),
             with_piece({0, 90, 10, 20}, kInside_px - 1.9f, 10),
         })
        EXPECT_EQ(with_frame_pieces_joined(map, 2).values, map.values);
}

TEST(FramePieces, TheFrameIsWhereTheMapBecomesKnown) {
    DisparityMap map = inside(), joined = inside();
    put(map, {50, 90, 10, 20}, 40, 10);
    for (DisparityMap* const each : {&map, &joined}) put(*each, {0, 0, 50, kMapRows}, kUnknownDisparity, 0);
    EXPECT_EQ(with_frame_pieces_joined(map, 2).values, joined.values);
}

TEST(FramePieces, WhatGoesOnBelowAPieceThatJoinsStays) {
    // A strip in front of a groove, and of what is as near as it.
    DisparityMap map = inside();
    put(map, {0, 0, 20, kMapRows}, 30, 20);
    put(map, {20, 100, 40, 100}, 30, 0);
    const DisparityMap result = with_frame_pieces_joined(map, 2);
    EXPECT_EQ(result.at(10, 99), kInside_px);
    EXPECT_EQ(result.at(10, 100), 30);
}

}  // namespace
}  // namespace hexrelief::stages
