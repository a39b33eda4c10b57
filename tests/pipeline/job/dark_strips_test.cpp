// Tests which dark parts of a picture are the strips that rectifying leaves.
#include "pipeline/job/pairs/dark_strips.h"

#include <gtest/gtest.h>

#include "pipeline/job/input.h"

namespace hexrelief::job {
namespace {

constexpr int kWidth = 60, kHeight = 40;

// A textured picture whose pixels are dark if is_dark(x, y).
template <typename IsDark>
Image picture(IsDark is_dark) {
    Image image{kWidth, kHeight, 1, {}};
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
            image.pixels.push_back(is_dark(x, y) ? static_cast<std::uint8_t>((x + y) % 3)
                                                 : static_cast<std::uint8_t>(60 + (x * 37 + y * 91) % 150));
    return image;
}

template <typename IsDark>
std::ptrdiff_t hidden(IsDark is_dark) {
    const readers::PixelMask mask = without_dark_strips(picture(is_dark));
    return std::count(mask.kept.begin(), mask.kept.end(), 0);
}

TEST(DarkStrips, AreHiddenAlongAnySide) {
    EXPECT_EQ(hidden([](int x, int) { return x < 5; }), 5 * kHeight);
    EXPECT_EQ(hidden([](int x, int) { return x >= kWidth - 3; }), 3 * kHeight);
    EXPECT_EQ(hidden([](int, int y) { return y < 4 || y >= kHeight - 6; }), 10 * kWidth);
    EXPECT_EQ(hidden([](int x, int y) { return x < 5 || y < 4; }), 5 * kHeight + 4 * kWidth - 20);
    EXPECT_EQ(hidden([](int x, int y) { return x < 4 + y / 8; }), 8 * (4 + 5 + 6 + 7 + 8))
        << "a slanted strip";
}

// Lines thinner than 2 px are left.
TEST(DarkStrips, MayBeWedges) {
    constexpr int kWedge = 3 * (8 + 7 + 6 + 5 + 4 + 3 + 2);
    EXPECT_EQ(hidden([](int x, int y) { return x < 8 - y / 3; }), kWedge);
    EXPECT_EQ(hidden([](int x, int y) { return x >= kWidth - 8 + (kHeight - 1 - y) / 3; }), kWedge);
    EXPECT_EQ(hidden([](int x, int y) { return x < 8 - y / 3 || x >= kWidth - 8 + (kHeight - 1 - y) / 3; }),
              2 * kWedge);
    EXPECT_EQ(hidden([](int x, int y) { return y < 8 - x / 3; }), kWedge);
    EXPECT_EQ(hidden([](int x, int y) { return x * x + y * y < 100; }), 0) << "a round thing in a corner";
    EXPECT_EQ(hidden([](int x, int y) { return x < 8 - std::abs(y - 20) / 2; }), 0)
        << "it begins at no corner";
}

TEST(DarkStrips, OtherDarkPartsAreKept) {
    EXPECT_EQ(hidden([](int, int) { return false; }), 0);
    EXPECT_EQ(hidden([](int, int) { return true; }), 0) << "a black picture";
    EXPECT_EQ(hidden([](int x, int) { return x < 1; }), 0) << "a single column";
    EXPECT_EQ(hidden([](int x, int) { return x < 20; }), 0) << "a third of the picture";
    EXPECT_EQ(hidden([](int x, int y) { return x < 5 && y < 30; }), 0) << "something dark at the side";
    EXPECT_EQ(hidden([](int x, int y) { return x < 4 + y % 5; }), 0) << "leaves before a dark background";
    EXPECT_EQ(hidden([](int x, int y) { return x > 9 && x < 14 && y > 0; }), 0) << "a pole";
    Image dusk = picture([](int, int) { return false; });
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) dusk.at(x, y)[0] = static_cast<std::uint8_t>(3 * x / 2);
    EXPECT_TRUE(without_dark_strips(dusk).empty()) << "a shade that becomes bright slowly";
}

TEST(DarkStrips, OfAPairAreUnknown) {
    RunLog log;
    config::InputConfig config;
    config.calibration.focal_px = 50;
    config.calibration.baseline_m = 1;
    config.rectify = config::PairRectification::never;
    const Image left = picture([](int x, int) { return x >= kWidth - 5; }),
                right = picture([](int x, int) { return x < 5; });
    const RunInput input = read_input(PairArrays{{left, right}}, config, {}, 1, log);
    ASSERT_FALSE(input.mask.empty());
    EXPECT_EQ(std::count(input.mask.kept.begin(), input.mask.kept.end(), 0), 5 * kHeight);
    EXPECT_EQ(input.mask.kept[kWidth - 1], 0);
    EXPECT_TRUE(input.pair()->is_masked);
}

}  // namespace
}  // namespace hexrelief::job
