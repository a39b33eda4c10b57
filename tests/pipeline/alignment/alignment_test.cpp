#include "pipeline/alignment/alignment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "pipeline/alignment/resample.h"
#include "turned_pair.h"

namespace hexrelief::alignment {
namespace {

constexpr int kThreads = 2;

Alignment aligned_by(const TurnedCameras& cameras, double focal_px) {
    return find_alignment(render_pair(cameras), {focal_px}, kThreads);
}

// What matches tell of the angles that both cameras share is less than of those between them: a common turn
// moves rows by a share of the disparity only.
void expect_angles(const Alignment& alignment, const TurnedCameras& cameras) {
    constexpr double kRelative = 0.03, kCommon = 0.35;
    const Angles found = angles_of(alignment.estimate.fit.parameters);
    EXPECT_NEAR(found.pitch, cameras.pitch, kRelative);
    EXPECT_NEAR(found.yaw, cameras.yaw, kRelative);
    EXPECT_NEAR(found.roll, cameras.roll, kRelative);
    EXPECT_NEAR(found.common_yaw, cameras.common_yaw, kCommon);
    EXPECT_NEAR(found.common_roll, cameras.common_roll, kCommon);
}

// The same cameras with the pictures at which points are looked for.
TurnedCameras enlarged(TurnedCameras cameras) {
    cameras.focal_px *= 2;
    cameras.width *= 2;
    cameras.height *= 2;
    return cameras;
}

struct Case {
    const char* name;
    TurnedCameras cameras;
};

class Turned : public testing::TestWithParam<Case> {};

TEST_P(Turned, AnglesComeBackIfTheFocalLengthIsKnown) {
    const TurnedCameras cameras = enlarged(GetParam().cameras);
    const Alignment alignment = aligned_by(cameras, cameras.focal_px);
    ASSERT_EQ(alignment.verdict, Verdict::aligned) << alignment.reason;
    EXPECT_LT(alignment.estimate.held_out.median_px, 0.15);
    EXPECT_TRUE(alignment.is_focal_determined());
    expect_angles(alignment, cameras);
}

INSTANTIATE_TEST_SUITE_P(
    Alignment, Turned,
    testing::Values(Case{"pitch", {.pitch = 1.5, .right_focal = 1.01}}, Case{"yaw", {.yaw = 5}},
                    Case{"all", {.pitch = -5, .yaw = 4, .roll = 5, .common_yaw = 3, .common_roll = -4}},
                    Case{"radial", {.pitch = 1, .yaw = 3, .roll = 1, .radial = 0.05}},
                    Case{"barrel", {.pitch = -2, .yaw = 2, .roll = 1, .radial = -0.05}}),
    [](const testing::TestParamInfo<Case>& tested) { return std::string(tested.param.name); });

TEST(Alignment, FocalLengthComesBackOrIsToldToBeUnknown) {
    int determined = 0;
    for (const double focal_px : {480.0, 576.0, 691.0}) {
        const TurnedCameras cameras{
            .pitch = 5, .yaw = 5, .roll = -4, .common_yaw = 5, .common_roll = 3, .focal_px = focal_px};
        const Alignment alignment = aligned_by(cameras, 0);
        ASSERT_EQ(alignment.verdict, Verdict::aligned) << alignment.reason;
        if (!alignment.is_focal_determined()) continue;
        ++determined;
        EXPECT_NEAR(alignment.focal_px, focal_px, 0.03 * focal_px);
    }
    EXPECT_GT(determined, 0);
    // The rows of cameras that are only rolled say nothing of their focal length.
    EXPECT_FALSE(aligned_by({.roll = 2}, 0).is_focal_determined());
}

TEST(Alignment, DisparitiesAreThoseOfTheScene) {
    const TurnedCameras cameras{.pitch = 2, .yaw = 3, .roll = 1};
    const Alignment alignment = aligned_by(cameras, cameras.focal_px);
    ASSERT_EQ(alignment.verdict, Verdict::aligned) << alignment.reason;
    const DisparityBounds& found = alignment.disparities;
    const double strength = cameras.focal_px * cameras.baseline;  // 6 to 2 m away
    EXPECT_TRUE(found.is_infinity_known);
    EXPECT_NEAR(found.least_px - found.infinity_px, strength / 6, 1.5);
    EXPECT_NEAR(found.largest_px - found.infinity_px, strength / 2, 1.5);
    EXPECT_GT(found.least_px, 0);
}

TEST(Alignment, ASceneOfUnknownDepthIsAQuarterAsDeepAsWide) {
    for (const auto& [focal_px, farthest] : {std::pair{640.0, 1 / 0.75}, {1280.0, 1 / 0.875}, {160.0, 4.0}}) {
        std::vector<Match> matches;  // from -10 to 10 px: a stereo window
        for (int i = 0; i <= 400; ++i) matches.push_back({{i + i / 20.0 - 10, 9}, {1.0 * i, 9}});
        const DisparityBounds bounds = bounds_as_given(as_given({640, 480, focal_px}, matches), 1);
        EXPECT_FALSE(bounds.is_infinity_known);
        EXPECT_NEAR((bounds.largest_px - bounds.infinity_px) / (bounds.least_px - bounds.infinity_px),
                    farthest, 1e-9);
    }
}

TEST(Alignment, TheAlignedPairIsRectified) {
    const StereoPair pair =
        render_pair({.pitch = 3, .yaw = 3, .roll = 2, .common_yaw = -2, .common_roll = 2, .radial = 0.03});
    const Alignment alignment = find_alignment(pair, {576}, kThreads);
    ASSERT_EQ(alignment.verdict, Verdict::aligned) << alignment.reason;
    const AlignedPair aligned = aligned_pair(pair, alignment, kThreads);
    const Calibration camera = camera_of(alignment);
    EXPECT_EQ(aligned.pair.left.width, camera.width);
    EXPECT_EQ(aligned.seen.size(), aligned.pair.left.pixels.size());
    EXPECT_NE(std::count(aligned.seen.begin(), aligned.seen.end(), 0), 0);
    const Alignment again = find_alignment(aligned.pair, {camera.focal_px}, kThreads);
    EXPECT_EQ(again.verdict, Verdict::rectified);
    EXPECT_LT(again.estimate.before.median_px, 0.15);
    EXPECT_NEAR(again.disparities.least_px, alignment.disparities.least_px, 1.5);
    EXPECT_NEAR(again.disparities.largest_px, alignment.disparities.largest_px, 1.5);
}

// Returns how many left pixels are kept though the right view shows nothing at these disparities or less.
int seen_only_nearer(const AlignedPair& aligned, double disparity_px) {
    constexpr int kEroded = 5;  // of both views' borders
    const int width = aligned.pair.left.width, reach = static_cast<int>(disparity_px) + kEroded;
    int count = 0;
    for (int y = 0; y < aligned.pair.left.height; ++y) {
        const auto row = aligned.right_seen.begin() + static_cast<std::ptrdiff_t>(y) * width;
        for (int x = reach; x < width; ++x)
            count += aligned.seen[static_cast<std::size_t>(y) * width + x] != 0 &&
                     std::find(row + x - reach, row + x + 1, 1) == row + x + 1;
    }
    return count;
}

TEST(Alignment, ANarrowStripThatShowsOnlyNearThingsIsDropped) {
    for (const bool is_narrow : {true, false}) {
        const TurnedCameras cameras{.pitch = 1, .yaw = -6, .roll = 1, .baseline = is_narrow ? 0.1 : 0.4};
        const StereoPair pair = render_pair(cameras);
        const Alignment alignment = find_alignment(pair, {cameras.focal_px}, kThreads);
        ASSERT_EQ(alignment.verdict, Verdict::aligned) << alignment.reason;
        const DisparityBounds& bounds = alignment.disparities;
        const double far_px = bounds.least_px + 0.25 * (bounds.largest_px - bounds.least_px);
        const int only_near = seen_only_nearer(aligned_pair(pair, alignment, kThreads), far_px);
        EXPECT_EQ(only_near == 0, is_narrow) << only_near << " px";
    }
}

TEST(Alignment, RectifiedPairsStayAsTheyAre) {
    EXPECT_EQ(aligned_by({}, 0).verdict, Verdict::rectified);
    EXPECT_EQ(aligned_by({.pitch = 0.02}, 0).verdict, Verdict::rectified);
    const StereoPair pair = render_pair({});
    EXPECT_EQ(find_alignment(pair, {.always = true}, kThreads).verdict, Verdict::aligned);
}

TEST(Alignment, ExchangedViewsAreNoticed) {
    StereoPair pair = render_pair({.pitch = 1, .roll = 1});
    std::swap(pair.left, pair.right);
    const Alignment alignment = find_alignment(pair, {576}, kThreads);
    ASSERT_EQ(alignment.verdict, Verdict::aligned) << alignment.reason;
    EXPECT_TRUE(alignment.estimate.is_exchanged);
    EXPECT_GT(alignment.disparities.least_px - alignment.disparities.infinity_px, 10);
}

TEST(Alignment, TheOrderMayBeGiven) {
    // As for a stereo window: disparities of both signs, so that points tell no order.
    const StereoPair pair = render_pair({.yaw = 2});
    const auto aligned = [&](Order order) {
        return find_alignment(pair, {.focal_px = 576, .is_rig = true, .order = order}, kThreads);
    };
    EXPECT_FALSE(aligned(Order::by_points).estimate.is_exchanged);
    const Alignment exchanged = aligned(Order::exchanged), as_given = aligned(Order::as_given);
    ASSERT_EQ(exchanged.verdict, Verdict::aligned) << exchanged.reason;
    EXPECT_TRUE(exchanged.estimate.is_exchanged);
    EXPECT_FALSE(as_given.estimate.is_exchanged);
    // What is near in one order is far in the other.
    EXPECT_NEAR(exchanged.disparities.largest_px - exchanged.disparities.least_px,
                as_given.disparities.largest_px - as_given.disparities.least_px, 3);
    // A rectified pair in the wrong order has to be resampled as well.
    EXPECT_EQ(find_alignment(render_pair({}), {.order = Order::exchanged}, kThreads).verdict,
              Verdict::aligned);
}

TEST(Alignment, AFlatSceneKeepsTheOrderThatWasGiven) {
    // A narrow view of little but the wall: rows alone have it 4 to 8 px behind infinity.
    const StereoPair pair = render_pair(
        {.pitch = 1, .yaw = 1.5, .focal_px = 1500, .baseline = 0.02, .width = 320, .height = 240, .seed = 8});
    EXPECT_FALSE(find_alignment(pair, {}, kThreads).estimate.is_exchanged);
}

TEST(Alignment, CamerasAboveEachOtherAreTurned) {
    const Alignment alignment = aligned_by({.yaw = 1, .common_roll = 88}, 576);
    ASSERT_EQ(alignment.verdict, Verdict::aligned) << alignment.reason;
    EXPECT_LT(alignment.estimate.held_out.median_px, 0.15);
    EXPECT_GT(alignment.disparities.least_px - alignment.disparities.infinity_px, 10);
    const std::array<double, 2> up = up_of(alignment);
    EXPECT_NEAR(std::fabs(up[0]), 1, 0.01);
    EXPECT_NEAR(up[1], std::cos(88 * kDegree), 0.03);
}

TEST(Alignment, UpIsWhereTheLeftPictureHasIt) {
    EXPECT_NEAR(up_of(aligned_by({.pitch = 1, .roll = 1}, 576))[1], 1, 1e-3);
    const std::array<double, 2> up = up_of(aligned_by({.pitch = 1, .common_roll = 30}, 576)),
                                other = up_of(aligned_by({.pitch = 1, .common_roll = -30}, 576));
    EXPECT_NEAR(up[1], std::cos(30 * kDegree), 0.02);
    EXPECT_NEAR(std::fabs(up[0]), 0.5, 0.02);
    EXPECT_NEAR(up[0], -other[0], 0.04);
}

TEST(Alignment, SaysWhyItRefuses) {
    const auto refusal = [](const TurnedCameras& cameras) {
        const Alignment alignment = aligned_by(cameras, cameras.focal_px);
        EXPECT_EQ(alignment.verdict, Verdict::refused);
        return alignment.reason;
    };
    EXPECT_NE(refusal({.pitch = 2, .yaw = 3, .baseline = 0}).find("turned, not moved"), std::string::npos);
    EXPECT_NE(refusal({.pitch = 1, .baseline = 0, .forward = 0.6}).find("forward"), std::string::npos);
}

TEST(Alignment, RefusesMirroredAndUnrelatedPictures) {
    StereoPair pair = render_pair({});
    for (int y = 0; y < pair.right.height; ++y)
        std::reverse(pair.right.at(0, y), pair.right.at(0, y) + pair.right.width);
    EXPECT_NE(find_alignment(pair, {}, kThreads).verdict, Verdict::aligned);
    pair.right = render_pair({.seed = 1000}).right;
    EXPECT_NE(find_alignment(pair, {}, kThreads).verdict, Verdict::aligned);
}

// Puts a thing of 120 x 100 px into a picture.
void put_thing(Image& image, int x, int y) {
    for (int j = 0; j < 100; ++j)
        for (int i = 0; i < 120; ++i)
            *image.at(x + i, y + j) =
                static_cast<std::uint8_t>((i / 6 * 2654435761u ^ j / 6 * 2246822519u) >> 11);
}

TEST(Alignment, TellsWhatMovedBetweenThePictures) {
    const TurnedCameras cameras{.pitch = 1, .yaw = 2, .roll = 1};
    StereoPair pair = render_pair(cameras);
    EXPECT_EQ(find_alignment(pair, {cameras.focal_px}, kThreads).movers.points, 0);
    put_thing(pair.left, 300, 200);
    put_thing(pair.right, 280, 225);
    const Alignment moved = find_alignment(pair, {cameras.focal_px}, kThreads);
    ASSERT_EQ(moved.verdict, Verdict::aligned);
    EXPECT_GE(moved.movers.points, 8);
    EXPECT_NEAR(moved.movers.middle.x, 360, 40);
    EXPECT_NEAR(moved.movers.middle.y, 250, 40);
}

TEST(Alignment, TellsIfTooFewPointsAreFound) {
    const Image plain{320, 240, 1, std::vector<std::uint8_t>(std::size_t{320} * 240, 128)};
    const Alignment alignment = find_alignment({plain, plain}, {}, kThreads);
    EXPECT_EQ(alignment.verdict, Verdict::unclear);
    EXPECT_NE(alignment.reason.find("only 0 points are in both"), std::string::npos) << alignment.reason;
    EXPECT_EQ(find_alignment({Image{8, 8, 1, std::vector<std::uint8_t>(64)},
                              Image{8, 8, 1, std::vector<std::uint8_t>(64)}},
                             {}, kThreads)
                  .verdict,
              Verdict::unclear);
}

TEST(Alignment, IsTheSameForAnyNumberOfThreads) {
    const StereoPair pair = render_pair({.pitch = 3, .yaw = 2, .roll = 2, .radial = 0.03});
    const Alignment one = find_alignment(pair, {}, 1);
    const AlignedPair by_one = aligned_pair(pair, one, 1);
    for (const int threads : {2, 5}) {
        const Alignment many = find_alignment(pair, {}, threads);
        EXPECT_EQ(many.estimate.fit.parameters, one.estimate.fit.parameters);
        EXPECT_EQ(many.matches, one.matches);
        const AlignedPair by_many = aligned_pair(pair, many, threads);
        EXPECT_EQ(by_many.pair.left.pixels, by_one.pair.left.pixels);
        EXPECT_EQ(by_many.pair.right.pixels, by_one.pair.right.pixels);
        EXPECT_EQ(by_many.seen, by_one.seen);
    }
}

TEST(Alignment, WithoutTheRightPictureIsTheSameButForIt) {
    const StereoPair pair = render_pair({.pitch = 3, .yaw = 2, .roll = 2, .radial = 0.03});
    const Alignment alignment = find_alignment(pair, {}, kThreads);
    const AlignedPair whole = aligned_pair(pair, alignment, kThreads),
                      left = aligned_pair(pair, alignment, kThreads, false);
    EXPECT_EQ(left.pair.left.pixels, whole.pair.left.pixels);
    EXPECT_EQ(left.seen, whole.seen);
    EXPECT_EQ(left.right_seen, whole.right_seen);
    EXPECT_TRUE(left.pair.right.empty());
}

}  // namespace
}  // namespace hexrelief::alignment
