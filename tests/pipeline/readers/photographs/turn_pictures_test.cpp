// Tests which pictures are turned by their EXIF orientation.
#include "pipeline/readers/photographs/exif.h"

#include <gtest/gtest.h>

namespace hexrelief::readers {
namespace {

OrientedPicture picture(int width, int height, int orientation) {
    const auto pixels = static_cast<std::size_t>(width) * height;
    return {Image{width, height, 1, std::vector<std::uint8_t>(pixels), {}}, "a.jpg", orientation};
}

struct Size {
    int width, height;
};
std::string size_text(Size size) {
    return std::to_string(size.width) + "x" + std::to_string(size.height);
}

void add(const Turning& turning, Turning& to) {
    to.warnings.insert(to.warnings.end(), turning.warnings.begin(), turning.warnings.end());
}

std::string size_after(OrientedPicture left, OrientedPicture right, bool has_calibration, Turning& log) {
    add(turn_upright(left, right, has_calibration), log);
    return size_text({left.image.width, left.image.height}) + " " +
           size_text({right.image.width, right.image.height});
}

TEST(Orientation, BothPicturesOfAPairAreTurned) {
    Turning log;
    EXPECT_EQ(size_after(picture(4, 2, 6), picture(4, 2, 6), false, log), "2x4 2x4");
    EXPECT_EQ(size_after(picture(4, 2, 6), picture(2, 4, 1), false, log), "2x4 2x4");
    EXPECT_EQ(size_after(picture(4, 2, 1), picture(4, 2, 1), true, log), "4x2 4x2");
    EXPECT_TRUE(log.warnings.empty());
    EXPECT_EQ(size_after(picture(4, 2, 6), picture(4, 2, 8), true, log), "2x4 2x4");
    ASSERT_EQ(log.warnings.size(), 2u);
    EXPECT_NE(log.warnings[0].find("input.exif_orientation"), std::string::npos) << log.warnings[0];
}

TEST(Orientation, APairOfOneSizeKeepsIt) {
    Turning log;
    EXPECT_EQ(size_after(picture(4, 2, 6), picture(4, 2, 1), false, log), "4x2 4x2");
    ASSERT_EQ(log.warnings.size(), 1u);
    EXPECT_NE(log.warnings[0].find("taken as stored"), std::string::npos) << log.warnings[0];
}

TEST(Orientation, AMapsPictureIsTurnedIfThatFitsTheMap) {
    const auto fitted = [](OrientedPicture color, Size map, Turning& log) {
        add(turn_to_fit(color, map.width, map.height), log);
        return size_text({color.image.width, color.image.height});
    };
    Turning log;
    EXPECT_EQ(fitted(picture(8, 4, 6), {2, 4}, log), "4x8");
    EXPECT_EQ(fitted(picture(8, 4, 6), {8, 4}, log), "8x4");
    EXPECT_EQ(fitted(picture(8, 4, 1), {2, 4}, log), "8x4");
    EXPECT_TRUE(log.warnings.empty());
    EXPECT_EQ(fitted(picture(8, 4, 3), {8, 4}, log), "8x4");
    EXPECT_EQ(fitted(picture(8, 8, 6), {4, 4}, log), "8x8");
    ASSERT_EQ(log.warnings.size(), 2u) << "the sizes do not tell";
    EXPECT_NE(log.warnings[0].find("turned by half"), std::string::npos) << log.warnings[0];
}

}  // namespace
}  // namespace hexrelief::readers
