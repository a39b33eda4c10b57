// Tests the limits of what a run reads, and what becomes of a pair.
#include "pipeline/job/input.h"

#include <gtest/gtest.h>

#include "pipeline/data/crop.h"
#include "pipeline/job/pairs/align_pair.h"
#include "pipeline/readers/image_reader.h"
#include "tests/pipeline/process.h"

namespace hexrelief::job {
namespace {

TEST(RunInput, EveryPictureAndMapIsHeldAgainstTheLimitOfPixels) {
    const test::TemporaryFolder folder;
    const std::string large = folder / "large.pgm", stereo = folder / "stereo.pgm";
    test::write_text(large, "P5\n322 240\n255\n");  // refused by its header: there is no sample
    test::write_text(stereo, "P5\n322 240\n255\n");
    const std::filesystem::path map = test::sample("disparity.pfm"), left = test::sample("left.png");
    const std::vector<Source> sources = {
        PairFiles{large, left},
        PairFiles{left, large},
        StereoFile{stereo},
        DisparityFiles{large},
        DepthFiles{large},
        DisparityFiles{map, large},
        DisparityFiles{.map = map, .mask = large},
        DisparityFiles{.map = map, .confidence = large},
    };
    config::InputConfig config;
    config.stereo.layout = readers::StereoLayout::side_by_side;
    for (std::size_t i = 0; i < sources.size(); ++i) {
        RunLog log;
        EXPECT_CONTAINS(
            test::error_of([&] { read_input(sources[i], config, {.max_pixels = 320 * 240}, 1, log); }),
            "its size is 322x240, more than the limit of 76800 pixels (limits.max_pixels)")
            << i;
    }
}

TEST(RunInput, DepthsAreInTheUnitAndOfTheCameraThatTheFileSaysForThem) {
    const test::TemporaryFolder folder;
    const std::string map = folder / "000003.pgm", camera = folder / "scene_camera.json";
    test::write_text(map, std::string("P5\n2 1\n65535\n\x27\x10\x13\x88", 17));  // 10000 and 5000
    test::write_text(camera, R"({"2": {"cam_K": [7, 0, 1, 0, 7, 0.5, 0, 0, 1], "depth_scale": 1.0},
                                 "3": {"cam_K": [9, 0, 1, 0, 9, 0.5, 0, 0, 1], "depth_scale": 0.1}})");
    config::InputConfig config;
    config.calibration.file = camera;
    const auto read = [&] {
        RunLog log;
        return read_input(DepthFiles{map}, config, {}, 1, log);
    };
    const RunInput input = read();
    const InputMap& depths = std::get<InputMap>(input.views);
    EXPECT_EQ(input.calibration.focal_px, 9);
    EXPECT_CONTAINS(depths.read_as, "1/10000 m, as the calibration file says");
    EXPECT_FLOAT_EQ(depths.disparities.values[1], 2 * depths.disparities.values[0]);
    EXPECT_FLOAT_EQ(depths.disparities.values[0], static_cast<float>(9 * input.calibration.baseline_m / 1.0))
        << "1 m";
    config.depth.unit = "mm";
    EXPECT_CONTAINS(std::get<InputMap>(read().views).read_as, "integers, mm");
}

Image columns(const Image& image, int first, int count) {
    Image part{count, image.height, image.channels, {}};
    for (int y = 0; y < image.height; ++y)
        part.pixels.insert(part.pixels.end(), image.at(first, y),
                           image.at(first, y) + count * image.channels);
    return part;
}

TEST(AlignPair, APairShiftedForAStereoWindowIsNotExchanged) {
    constexpr int shift = 40;
    const Image left = readers::read_image(test::sample("left.png")),
                right = readers::read_image(test::sample("right.png"));
    const auto doffs_of = [](const Image& first, const Image& second) {
        const config::InputConfig config;
        StereoPair views{first, second};
        return align_pair(views, {Calibration{.focal_px = 300}}, {config, "pair"}, 1)
            .camera.calibration.doffs_px;
    };
    const int width = left.width - shift;
    const Image window_left = columns(left, shift, width), window_right = columns(right, 0, width);
    EXPECT_GT(doffs_of(window_left, window_right), shift - 5) << "the least disparity of the sample is 5 px";
    EXPECT_EQ(doffs_of(window_right, window_left), 0) << "above 0 px, the pair is inside out";
    EXPECT_EQ(doffs_of(right, left), 0) << "exchanged, which the checks tell";
    EXPECT_EQ(doffs_of(left, right), 0);
}

// A stereo window leaves disparities of both signs, which tell no order; what only one view shows does.
TEST(AlignPair, AWindowedPairInTheWrongOrderIsExchanged) {
    constexpr int shift = 20, lower = 2;
    const Image left = readers::read_image(test::sample("left.png")),
                right = readers::read_image(test::sample("right.png"));
    const Image first = cropped(left, {shift, 0, left.width - shift, left.height - lower});
    const auto exchanged = [&](bool is_swapped, int top) {
        const config::InputConfig config;
        StereoPair views{first, cropped(right, {0, top, first.width, first.height})};
        if (is_swapped) std::swap(views.left, views.right);
        const PairAlignment done =
            align_pair(views, {Calibration{.focal_px = 300}}, {config, "pair", true}, 1);
        EXPECT_FALSE(done.found.disparities.is_infinity_known);
        return done.found.estimate.is_exchanged;
    };
    EXPECT_FALSE(exchanged(false, 0)) << "rows are the same";
    EXPECT_TRUE(exchanged(true, 0));
    EXPECT_FALSE(exchanged(false, lower)) << "rows have to be aligned";
    EXPECT_TRUE(exchanged(true, lower));
}

TEST(AlignPair, APairThatSurelyLiesInFrontIsNotExchanged) {
    constexpr int shift = 60, lower = 2;
    const Image left = readers::read_image(test::sample("left.png")),
                right = readers::read_image(test::sample("right.png"));
    const config::InputConfig config;
    StereoPair views{cropped(right, {0, lower, right.width - shift, right.height - lower}),
                     cropped(left, {shift, 0, left.width - shift, left.height - lower})};
    const PairAlignment done = align_pair(views, {Calibration{.focal_px = 300}, true}, {config, "pair"}, 1);
    ASSERT_TRUE(is_aligned(done.found));
    EXPECT_TRUE(done.found.disparities.is_infinity_known);
    EXPECT_FALSE(done.found.estimate.is_exchanged) << "though what only one view shows tells so";
}

}  // namespace
}  // namespace hexrelief::job
