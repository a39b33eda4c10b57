#include "pipeline/data/shrink.h"

#include <gtest/gtest.h>

namespace hexrelief {
namespace {

TEST(Shrink, GivesTheMeansOfSquares) {
    const Image image{4, 2, 1, {0, 1, 250, 251, 2, 3, 252, 255}};
    const Image half = shrunk(image, 2);
    EXPECT_EQ(half.width, 2);
    EXPECT_EQ(half.height, 1);
    EXPECT_EQ(half.pixels, (std::vector<std::uint8_t>{2, 252})) << "1.5 is rounded up";
    EXPECT_EQ(shrunk(image, 1).pixels, image.pixels);
}

TEST(Shrink, SquaresAtTheEdgesCoverWhatIsLeft) {
    const Image image{3, 3, 3, {0,  100, 200, 4,  100, 200, 9, 9, 9,  //
                                8,  100, 200, 12, 100, 200, 9, 9, 9,  //
                                40, 41,  42,  44, 45,  46,  7, 8, 9}};
    const Image half = shrunk(image, 2);
    EXPECT_EQ(half.channels, 3);
    EXPECT_EQ(half.pixels, (std::vector<std::uint8_t>{6, 100, 200, 9, 9, 9, 42, 43, 44, 7, 8, 9}));
    EXPECT_EQ(shrunk(image, 5).pixels.size(), 3u) << "one pixel is left";
}

}  // namespace
}  // namespace hexrelief
