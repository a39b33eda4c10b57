// Tests that the committed sample files are those that the generator makes.
#include <gtest/gtest.h>

#include <algorithm>

#include "pipeline/readers/cameras/calibration_reader.h"
#include "pipeline/readers/disparity_reader.h"
#include "pipeline/readers/image_reader.h"
#include "samples/sample_pair.h"

namespace hexrelief::stages {
namespace {

const std::filesystem::path kFolder = std::filesystem::path(HEXRELIEF_SOURCE_DIR) / "samples";

TEST(Samples, AreWhatTheGeneratorRenders) {
    const samples::SampleScene scene = samples::render_sample_scene();
    EXPECT_EQ(readers::read_image(kFolder / "left.png").pixels, scene.pair.left.pixels);
    EXPECT_EQ(readers::read_image(kFolder / "right.png").pixels, scene.pair.right.pixels);
    EXPECT_EQ(readers::read_disparity_map(kFolder / "disparity.pfm", {}).values, scene.disparity.values);
    const Calibration read = readers::read_calibration_file(kFolder / "calib.txt").calibration;
    EXPECT_DOUBLE_EQ(read.focal_px, scene.calibration.focal_px);
    EXPECT_DOUBLE_EQ(read.cx, scene.calibration.cx);
    EXPECT_DOUBLE_EQ(read.cy, scene.calibration.cy);
    EXPECT_DOUBLE_EQ(read.baseline_m, scene.calibration.baseline_m);
    EXPECT_DOUBLE_EQ(read.doffs_px, 0);
    EXPECT_TRUE(read.metric);
}

TEST(Samples, TruthMovesTheLeftViewOntoTheRight) {
    const StereoPair pair{readers::read_image(kFolder / "left.png"),
                          readers::read_image(kFolder / "right.png")};
    const DisparityMap truth = readers::read_disparity_map(kFolder / "disparity.pfm", {});
    long long near = 0, all = 0;
    for (int y = 0; y < truth.height; ++y) {
        for (int x = 41; x < truth.width; ++x) {
            const double match = x - truth.at(x, y);
            const int left = static_cast<int>(match);
            const double share = match - left;
            const double there =
                (1 - share) * pair.right.at(left, y)[1] + share * pair.right.at(left + 1, y)[1];
            near += std::abs(there - pair.left.at(x, y)[1]) < 12;
            ++all;
        }
    }
    EXPECT_GT(100.0 * near / all, 80);  // the rest is hidden in the right view, or at edges
    const auto [low, high] = std::minmax_element(truth.values.begin(), truth.values.end());
    EXPECT_NEAR(*low, 4.2, 0.3);
    EXPECT_NEAR(*high, 39.7, 0.3);
}

}  // namespace
}  // namespace hexrelief::stages
