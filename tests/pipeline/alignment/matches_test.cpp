
#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "pipeline/alignment/matches.h"
#include "turned_pair.h"

namespace hexrelief::alignment {
namespace {

TEST(ReducedGrey, IsTheMeanOverTheAreaOfAPixel) {
    ThreadPool pool(2);
    // 3 x 3 px to 2 x 2: each covers one and a half columns and rows.
    const Image image{3, 3, 1, {0, 30, 60, 90, 120, 150, 180, 210, 240}};
    const GreyPicture reduced = reduced_grey(image, 2, pool);
    EXPECT_EQ(reduced.values, (std::vector<std::uint8_t>{40, 80, 160, 200}));
    EXPECT_EQ(reduced_grey(image, 3, pool).values, image.pixels);
}

TEST(Descriptors, DifferByTheirBits) {
    const Descriptor a = {~0ull, 0, 0x123456789abcdef0ull, 7}, b = {0, ~0ull, 0x0fedcba987654321ull, 8};
    int bits = 0;
    for (std::size_t i = 0; i < a.size(); ++i) bits += std::popcount(a[i] ^ b[i]);
    EXPECT_EQ(hamming_distance(a, b), bits);
    EXPECT_EQ(hamming_distance({~0ull, ~0ull, ~0ull, ~0ull}, {}), 256);
    EXPECT_EQ(hamming_distance(a, a), 0);
}

TEST(Matches, FindAShiftOfAThirdOfAPixel) {
    ThreadPool pool(2);
    const StereoPair large = render_pair({.baseline = 0, .width = 1800, .height = 1200});
    // The right picture begins 30 columns and 7 rows later, which are 10 and 7 / 3 px at a third of the size.
    const auto part = [&](int x, int y) {
        Image image{1500, 1050, 1, {}};
        for (int row = 0; row < image.height; ++row)
            image.pixels.insert(image.pixels.end(), large.left.at(x, y + row),
                                large.left.at(x, y + row) + image.width);
        return reduced_grey(image, 500, pool);
    };
    const std::vector<Match> matches = find_matches(part(0, 0), part(30, 7), pool);
    ASSERT_GT(matches.size(), 200u);
    int good = 0;
    for (const Match& match : matches)
        good += std::fabs(match.left.x - match.right.x - 10) < 0.2 &&
                std::fabs(match.left.y - match.right.y - 7.0 / 3) < 0.2;
    EXPECT_GT(good, 0.9 * static_cast<double>(matches.size()));
}

}  // namespace
}  // namespace hexrelief::alignment
