// Tests the readers on Middlebury's own files, if HEXRELIEF_DATA names their folder.
#include <algorithm>
#include <cstdlib>

#include "pipeline/readers/cameras/calibration_reader.h"
#include "pipeline/readers/disparity_reader.h"
#include "pipeline/readers/image_reader.h"
#include "tests/pipeline/readers/sample_files.h"

namespace hexrelief::readers {
namespace {

class MiddleburyData : public testing::Test {
  protected:
    void SetUp() override {
        const char* folder = std::getenv("HEXRELIEF_DATA");
        if (!folder) GTEST_SKIP() << "HEXRELIEF_DATA is not set: Middlebury's files are not tested";
        folder_ = folder;
    }
    std::filesystem::path folder_;
};

TEST_F(MiddleburyData, PianoIsInPixels) {
    const auto piano = folder_ / "middlebury2014-quarter/Piano";
    const DisparityMap map = read_disparity_map(piano / "disp.pfm", {});
    const Calibration calibration = read_calibration_file(piano / "calib.txt").calibration;
    ASSERT_EQ(map.width, 707);
    ASSERT_EQ(map.height, 481);
    EXPECT_EQ(calibration.width, map.width);
    EXPECT_EQ(calibration.height, map.height);
    float low = 1e9f, high = 0;
    for (float d : map.values)
        if (DisparityMap::known(d)) low = std::min(low, d), high = std::max(high, d);
    EXPECT_GT(low, 8);  // calib.txt: vmin=9, vmax=55
    EXPECT_LT(high, 56);
    EXPECT_GT(high, 50);
}

TEST_F(MiddleburyData, PairsAndMapsFit) {
    for (const auto& [scene, name, scale] : {std::tuple{"middlebury2001/venus", "disp.pgm", 8},
                                             {"middlebury2003/cones-quarter", "disp.png", 4},
                                             {"middlebury2003/teddy-half", "disp.pgm", 2},
                                             {"middlebury2006/aloe-full", "disp.png", 1}}) {
        const auto folder = folder_ / scene;
        const DisparityMap map = read_disparity_map(folder / name, {.scale = double(scale)});
        const char* left = nullptr;
        for (const char* candidate : {"left.png", "left.ppm", "left.pgm"})
            if (std::filesystem::exists(folder / candidate)) left = candidate;
        ASSERT_NE(left, nullptr) << scene;
        const Image image = read_image(folder / left);
        EXPECT_EQ(image.width, map.width) << scene;
        EXPECT_EQ(image.height, map.height) << scene;
        const auto known = std::count_if(map.values.begin(), map.values.end(), DisparityMap::known);
        EXPECT_GT(static_cast<double>(known), 0.7 * static_cast<double>(map.values.size())) << scene;
    }
}

}  // namespace
}  // namespace hexrelief::readers
