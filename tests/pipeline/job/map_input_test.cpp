// Tests what happens to supplied disparities before the stages.
#include <gtest/gtest.h>

#include "pipeline/job/input.h"
#include "pipeline/job/maps/disparity_input.h"
#include "tests/expect_error.h"

namespace hexrelief::job {
namespace {

using Values = std::vector<float>;

readers::DisparityFile file_of(const Values& values) {
    return {{static_cast<int>(values.size()), 1, values}, "floats, px"};
}

TEST(DisparityInput, OnlyWhatLiesBeforeInfinityIsKept) {
    readers::DisparityFile file = file_of({-3, 0, 5, kUnknownDisparity});
    EXPECT_EQ(keep_in_front(file, 4).size(), 0u);
    EXPECT_EQ(file.map.values, (Values{-3, 0, 5, kUnknownDisparity}));
    const auto warnings = keep_in_front(file, 0);
    EXPECT_EQ(file.map.values, (Values{kUnknownDisparity, kUnknownDisparity, 5, kUnknownDisparity}));
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_NE(warnings[0].find("66.7 % of the map's disparities"), std::string::npos) << warnings[0];
    EXPECT_NE(warnings[0].find("--disparity-scale -1"), std::string::npos) << warnings[0];
}

TEST(DisparityInput, FewBeyondInfinityAreNotTold) {
    Values values(100, 8);
    values[3] = -0.25f;
    readers::DisparityFile file = file_of(values);
    EXPECT_TRUE(keep_in_front(file, 0).empty());
    EXPECT_EQ(file.map.values[3], kUnknownDisparity);
}

TEST(DisparityInput, ATurnedSignIsTold) {
    readers::DisparityFile file = file_of({-3, -4});
    const std::string text = test::error_of([&] { keep_in_front(file, 1); });
    EXPECT_CONTAINS(text, "from -4 to -3 px, none above -1 px");
    EXPECT_CONTAINS(text, "--disparity-scale -1");
}

TEST(DisparityInput, AnAssumedScaleOfIntegersIsDoubted) {
    const auto warned = [](float px, bool is_assumed) {
        readers::DisparityFile file{{1000, 1, Values(1000, px)}, "", is_assumed};
        return !keep_in_front(file, 0).empty();
    };
    EXPECT_TRUE(warned(8, true)) << "128 px as StereoSGBM's";
    EXPECT_FALSE(warned(8, false));
    EXPECT_FALSE(warned(60, true)) << "as usual with KITTI's scale";
    EXPECT_FALSE(warned(0.5f, true)) << "8 px as StereoSGBM's are not usual either";
}

TEST(DisparityInput, DoffsMakesDisparitiesBelowZeroDepths) {
    RunLog log;
    config::InputConfig config;
    config.calibration.focal_px = 10;
    config.calibration.baseline_m = 1;
    config.calibration.doffs_px = 6;
    const RunInput input =
        read_input(DisparityArrays{{{3, 1, {-2, 4, -7}}, "floats, px"}}, config, {}, 1, log);
    EXPECT_EQ(input.map()->disparities.values, (Values{-2, 4, kUnknownDisparity}));
    EXPECT_EQ(input.map()->read_as, "floats, px");
    EXPECT_FALSE(input.map()->is_depth);
}

DisparityMap rows_of(int width, int height) {
    DisparityMap map{width, height, {}};
    for (int y = 0; y < height; ++y)
        map.values.insert(map.values.end(), static_cast<std::size_t>(width), static_cast<float>(y));
    return map;
}

TEST(FitMap, ASmallDifferenceOfTheAspectIsStretched) {
    DisparityMap map = rows_of(140, 112);  // 4 : 3 rounded to multiples of 14
    const std::string done = fit_to_picture(map, 400, 312);
    EXPECT_EQ(map.width, 140);
    EXPECT_EQ(map.height, 109);
    EXPECT_EQ(map.values.size(), 140u * 109);
    EXPECT_EQ(map.at(7, 0), 0);
    EXPECT_EQ(map.at(7, 54), 56) << "the middle row";
    EXPECT_EQ(map.at(7, 108), 111);
    EXPECT_NE(done.find("stretched to 140x109 px"), std::string::npos) << done;
}

TEST(FitMap, APaddedMapIsCutEvenlyAResizedOneIsNot) {
    DisparityMap map = rows_of(96, 64);
    map.at(13, 7) = 99;
    const std::string done = fit_to_picture(map, 70, 50);
    EXPECT_EQ(map.width, 70);
    EXPECT_EQ(map.height, 50);
    EXPECT_EQ(map.at(0, 0), 99);
    EXPECT_EQ(map.at(69, 49), 56);
    EXPECT_NE(done.find("padded"), std::string::npos) << done;
    // Multiples of 14, less than 14 px larger than the picture.
    DisparityMap resized = rows_of(518, 350);
    EXPECT_NE(fit_to_picture(resized, 510, 340).find("stretched"), std::string::npos);
    EXPECT_EQ(resized.width, 518);
    EXPECT_EQ(resized.height, 345);
}

TEST(FitMap, OtherMapsStayAsTheyAre) {
    for (const auto& [width, height] : {std::pair{200, 100}, {400, 200}, {150, 100}, {100, 200}}) {
        DisparityMap map = rows_of(200, 100);
        EXPECT_EQ(fit_to_picture(map, width, height), "");
        EXPECT_EQ(map.values, rows_of(200, 100).values);
    }
    DepthMap depths{96, 64, Values(96 * 64, 1)};
    EXPECT_NE(fit_to_picture(depths, 70, 50), "");
    readers::PixelMask mask{96, 64, std::vector<std::uint8_t>(96 * 64, 1)};
    EXPECT_NE(fit_to_picture(mask, 70, 50), "");
    EXPECT_EQ(mask.kept.size(), 70u * 50);
}

TEST(FitMap, TheMaskOfARoundedMapIsFittedToo) {
    RunLog log;
    DisparityArrays source{{rows_of(140, 112), "floats, px"},
                           Image{400, 312, 1, std::vector<std::uint8_t>(400 * 312, 9)}};
    for (float& d : source.map.map.values) d += 1;
    source.mask = {140, 112, std::vector<std::uint8_t>(140 * 112, 1)};
    source.mask.kept[0] = 0;
    const RunInput input = read_input(std::move(source), {}, {}, 1, log);
    EXPECT_EQ(input.map()->disparities.height, 109);
    EXPECT_EQ(input.map()->disparities.at(0, 0), kUnknownDisparity);
    EXPECT_EQ(input.map()->disparities.at(1, 0), 1);
}

}  // namespace
}  // namespace hexrelief::job
