// What a run makes of a matched pair's map before it is meshed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string>

#include "pipeline/data/error.h"
#include "pipeline/job/disparities.h"
#include "pipeline/job/pairs/align_pair.h"
#include "pipeline/job/surfaces.h"

namespace hexrelief::job {
namespace {

// A textured picture, and a map of it that only has filled pixels, at a disparity of 4 px, or at 1 px in its
// first rows.
struct FilledPair {
    InputPair pictures{{Image{64, 64, 1, {}}, {}}};
    DisparityResult disparity{DisparityMap{64, 64, {}, {}}, stages::DisparityConfig{}};
    FilledPair() {
        for (unsigned i = 0; i < 64 * 64; ++i) {
            pictures.views.left.pixels.push_back(static_cast<std::uint8_t>(i * 2654435761u >> 24));
            disparity.map.values.push_back(i < 1024 ? 1.0f : 4.0f);
            disparity.map.origins.push_back(PixelOrigin::filled);
        }
    }
};

TEST(PairSteps, APairThatHardlySupportsItsMapIsToldAndStrictlyRefused) {
    FilledPair pair;
    RunLog log;
    judge_support(pair.disparity, pair.pictures, {}, false, 2, log);
    ASSERT_EQ(log.warnings().size(), 1u);
    EXPECT_NE(log.warnings()[0].find("hardly supports"), std::string::npos);
    EXPECT_THROW(judge_support(pair.disparity, pair.pictures, {}, true, 2, log), Error);
    pair.disparity.map.origins.assign(64 * 64, PixelOrigin::matched);
    judge_support(pair.disparity, pair.pictures, {}, true, 2, log);
    EXPECT_EQ(pair.disparity.support, 1);
    EXPECT_EQ(log.warnings().size(), 1u);
}

TEST(PairSteps, ABackdropEndsAPairAndIsCountedFromInfinity) {
    FilledPair pair;
    for (std::size_t i = 1024; i < 64 * 64; ++i) pair.disparity.map.origins[i] = PixelOrigin::matched;
    const RunLog log;
    Calibration camera{.focal_px = 100, .baseline_m = 1, .doffs_px = 2};
    DisparityResult endless = pair.disparity;
    end_scene(endless, camera, {.farthest = 0}, log);
    EXPECT_FALSE(endless.backdrop);
    EXPECT_EQ(endless.map.values, pair.disparity.map.values);
    end_scene(pair.disparity, camera, {.farthest = 1.2}, log);
    ASSERT_TRUE(pair.disparity.backdrop);
    EXPECT_FLOAT_EQ(pair.disparity.map.values[0], 3);  // (4 + 2) / 1.2 - 2
    pair.disparity.map.values[5] = 0;
    count_from_infinity(pair.disparity, camera, false, log);
    EXPECT_FLOAT_EQ(pair.disparity.backdrop->disparity_px, 5);
}

TEST(PairSteps, SurfacesContinueAsFarAsATurnBy20DegreesLooks) {
    DisparityMap map{100, 3, std::vector<float>(300, 40.0f)};
    std::fill_n(map.values.begin(), 100, kUnknownDisparity);
    std::fill_n(map.values.begin() + 100, 50, 200.0f);
    EXPECT_DOUBLE_EQ(baselines_of_turn(map, {.focal_px = 1000, .doffs_px = 100}, false), 2.6)
        << ".14 of the depth";
    EXPECT_DOUBLE_EQ(baselines_of_turn(map, {.focal_px = 1000, .doffs_px = 100}, true), 4.1);
    EXPECT_EQ(baselines_of_turn(map, {.focal_px = 1000, .doffs_px = 0}, false), 8) << "at most";
    EXPECT_EQ(baselines_of_turn(map, {.focal_px = 1000, .doffs_px = 900}, false), 1) << "at least";
    map.values.assign(300, kUnknownDisparity);
    EXPECT_EQ(baselines_of_turn(map, {.focal_px = 1000, .doffs_px = 0}, false), 1) << "nothing is known";
}

TEST(PairSteps, MoreBackgroundThanForegroundIsTold) {
    DisparityMap map{100, 100, std::vector<float>(10000, 2.0f)};
    const auto fill = [&](int rows) { std::fill_n(map.values.begin(), 100 * rows, 40.0f); };
    RunLog log;
    fill(55);
    density_of(map, {}, 1, log);
    EXPECT_TRUE(log.warnings().empty());
    map.values.assign(10000, 2.0f);
    fill(30);
    density_of(map, {.background_method = stages::BackgroundMethod::none}, 1, log);
    density_of(map, {.background_method = stages::BackgroundMethod::fraction}, 1, log);
    EXPECT_TRUE(log.warnings().empty()) << "as it was asked for";
    EXPECT_GT(density_of(map, {}, 1, log).background_px, 2);
    ASSERT_EQ(log.warnings().size(), 1u);
    EXPECT_EQ(
        log.warnings()[0],
        "more goes as background than stays, 70 % of what is known: all that lies farther than 4.0 times "
        "the nearest; set density.background.method=none to keep it");
}

// The farthest over the nearest distance of a relief whose matches lie from 0 to 30 px, with infinity at -90,
// and its map from 0 to 30 px, too.
double farthest_with(double noise_px) {
    DisparityMap map{300, 10, {}};
    for (int i = 0; i < 3000; ++i) map.values.push_back(static_cast<float>(i % 300) / 10);
    alignment::Alignment found;
    found.verdict = alignment::Verdict::aligned;
    found.disparities = {.least_px = 0, .largest_px = 30, .median_px = 15, .infinity_px = -90};
    const Calibration camera{.focal_px = 300, .baseline_m = 0.35, .doffs_px = 90};
    const Calibration flat = flattened(camera, found, {map, noise_px});
    EXPECT_NEAR(flat.baseline_m * flat.focal_px / (15 + flat.doffs_px), 1, 1e-6);  // the unit stays
    return (30 + flat.doffs_px) / flat.doffs_px;
}

TEST(PairSteps, ANoisyReliefIsShallower) {
    EXPECT_NEAR(farthest_with(0), 120. / 90, 0.01);
    EXPECT_NEAR(farthest_with(0.2), 120. / 90, 0.01);
    EXPECT_NEAR(farthest_with(0.6), 240. / 210, 0.01);
}

}  // namespace
}  // namespace hexrelief::job
