// Tests which pairs a calibration file rectifies, on the sample's pair as two turned cameras see it.
#include "pipeline/job/cameras/resolve_calibration.h"

#include <gtest/gtest.h>

#include "pipeline/alignment/rectify/rectify.h"
#include "pipeline/data/error.h"
#include "pipeline/readers/image_reader.h"
#include "tests/pipeline/process.h"

namespace hexrelief::job {
namespace {

const char* const kCameras =
    "K1: [81.6, 0, 38, 0, 81.6, 31, 0, 0, 1]\nD1: [-0.12, 0.02, 0, 0, 0]\n"
    "K2: [80.8, 0, 41, 0, 80.8, 28, 0, 0, 1]\nD2: [-0.1, 0.01, 0, 0, 0]\n"
    "R: [0.999911391, 0.011083481, -0.007373309, -0.010947761, 0.999774437, 0.018199501, 0.007573359, "
    "-0.018117167, 0.999807188]\nT: [-0.159991663, 0.001365367, 0.00089635]\n";
const char* const kRectified =
    "P1: [80, 0, 40, 0, 0, 80, 30, 0, 0, 0, 1, 0]\nP2: [80, 0, 40, -12.8, 0, 80, 30, 0, 0, 0, 1, 0]\n";

StereoPair sample_pair() {
    return {readers::read_image(test::sample("inputs/raw_left.png")),
            readers::read_image(test::sample("inputs/raw_right.png"))};
}

struct Rig {
    test::TemporaryFolder folder;
    config::InputConfig config;

    explicit Rig(const std::string& text) {
        test::write_text(folder / "rig.yml", text);
        config.calibration.file = folder / "rig.yml";
    }
    FileRectification rectify(StereoPair& pair) const { return rectify_by_file(pair, config, 1); }
};

TEST(RectifyByFile, ThePairTellsWhetherItWasRectified) {
    const Rig both(std::string(kCameras) + kRectified);
    StereoPair pair = sample_pair();
    const FileRectification raw = both.rectify(pair);
    EXPECT_TRUE(raw.is_done);
    ASSERT_EQ(raw.warnings.size(), 1u);
    EXPECT_CONTAINS(raw.warnings[0], "rectify=never");
    EXPECT_NEAR(raw.calibration.baseline_m, 0.16, 1e-4);
    const FileRectification again = both.rectify(pair);  // the same file, and the pair that it made
    EXPECT_FALSE(again.is_done);
    EXPECT_TRUE(again.warnings.empty());
    EXPECT_EQ(again.decisions.size(), 1u);
}

TEST(RectifyByFile, TheConfigurationGoesBefore) {
    Rig both(std::string(kCameras) + kRectified);
    StereoPair pair = sample_pair();
    both.config.calibration.rectify = readers::Rectify::never;
    EXPECT_FALSE(both.rectify(pair).is_done);
    both.config.calibration.rectify = readers::Rectify::always;
    EXPECT_TRUE(both.rectify(pair).is_done);
    const Rig raw(kCameras);
    pair = sample_pair();
    EXPECT_TRUE(raw.rectify(pair).warnings.empty());
}

TEST(RectifyByFile, CamerasOfAnotherSizeAreScaled) {
    const std::string doubled =
        "image_size: [160, 120]\nK1: [163.2, 0, 76.5, 0, 163.2, 62.5, 0, 0, 1]\nD1: [-0.12, 0.02, 0, 0, 0]\n"
        "K2: [161.6, 0, 82.5, 0, 161.6, 56.5, 0, 0, 1]\n";
    const Rig whole(kCameras),
        twice(doubled + std::string(kCameras).substr(std::string(kCameras).find("D2")));
    StereoPair one = sample_pair(), two = sample_pair();
    whole.rectify(one);
    const FileRectification scaled = twice.rectify(two);
    EXPECT_EQ(one.left.pixels, two.left.pixels);
    EXPECT_CONTAINS(scaled.decisions.at(0), "160x120");
    Rig other("image_size: [160, 90]\n" + std::string(kCameras));
    EXPECT_THROW(other.rectify(two), Error);
}

}  // namespace
}  // namespace hexrelief::job
