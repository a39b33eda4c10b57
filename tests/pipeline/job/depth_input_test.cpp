// Depth maps through whole jobs, against the disparity map that they were made from.
#include "pipeline/job/maps/depth_input.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "pipeline/data/error.h"
#include "pipeline/job/runner.h"
#include "pipeline/readers/cameras/calibration_reader.h"
#include "pipeline/readers/disparity_reader.h"
#include "tests/pipeline/process.h"

namespace hexrelief::job {
namespace {

struct DepthScene {
    Calibration camera;
    DisparityMap disparities;
    std::vector<float> depths;  // 0 = unknown
};

// The synthetic pair's.
DepthScene depth_scene() {
    DepthScene scene{readers::read_calibration(test::sample("calib.txt")),
                     readers::read_disparity_map(test::sample("disparity.pfm"), {}),
                     {}};
    for (const float d : scene.disparities.values)
        scene.depths.push_back(DisparityMap::known(d)
                                   ? static_cast<float>(scene.camera.focal_px * scene.camera.baseline_m /
                                                        (d + scene.camera.doffs_px))
                                   : 0);
    return scene;
}

void write_floats(const std::string& path, const DisparityMap& size, const std::vector<float>& values) {
    std::string pfm = "Pf\n" + std::to_string(size.width) + " " + std::to_string(size.height) + "\n-1\n";
    for (int y = size.height - 1; y >= 0; --y)
        pfm.append(reinterpret_cast<const char*>(values.data() + static_cast<std::size_t>(y) * size.width),
                   sizeof(float) * static_cast<std::size_t>(size.width));
    test::write_text(path, pfm);
}

RunRequest request_for(const test::TemporaryFolder& folder) {
    RunRequest request;
    request.config.input.calibration.file = test::sample("calib.txt");
    request.config.mesh.spacing_px = 8;
    request.report = folder / "r.json";
    request.outputs = {folder / "a.ply"};
    return request;
}

TEST(DepthInput, ADepthMapGivesTheMeshOfItsDisparityMap) {
    const test::TemporaryFolder folder;
    const DepthScene scene = depth_scene();
    RunRequest request = request_for(folder);
    request.disparity = test::sample("disparity.pfm");
    const RunReport expected = run_job(request, {});
    request.disparity.clear();
    request.depth = folder / "z.pfm";
    write_floats(request.depth, scene.disparities, scene.depths);
    const RunReport report = run_job(request, {});
    EXPECT_EQ(report.inputs.front().role, "depth");
    EXPECT_EQ(report.calibration.baseline_m, scene.camera.baseline_m);
    EXPECT_TRUE(report.calibration.metric);
    EXPECT_NEAR(static_cast<double>(report.triangles), static_cast<double>(expected.triangles),
                0.002 * static_cast<double>(expected.triangles));
    EXPECT_NEAR(report.surface_quality.rmse_near_px, expected.surface_quality.rmse_near_px, 0.01);
    EXPECT_NEAR(report.bounds.low.z, expected.bounds.low.z, 1e-3 * std::abs(expected.bounds.low.z));
    EXPECT_NEAR(report.bounds.high.x, expected.bounds.high.x, 1e-3 * std::abs(expected.bounds.high.x));
}

// The camera's doffs says nothing about depths.
TEST(DepthInput, FarDepthsAreThereWhateverTheDoffs) {
    const test::TemporaryFolder folder;
    const DepthScene scene = depth_scene();
    RunRequest request = request_for(folder);
    request.depth = folder / "z.pfm";
    write_floats(request.depth, scene.disparities, scene.depths);
    request.config.input.calibration.doffs_px = 0;
    const RunReport expected = run_job(request, {});
    request.config.input.calibration.doffs_px = 100;
    const RunReport report = run_job(request, {});
    EXPECT_EQ(report.calibration.doffs_px, 0);
    EXPECT_NEAR(static_cast<double>(report.triangles), static_cast<double>(expected.triangles), 3);
    EXPECT_NEAR(report.bounds.low.z, expected.bounds.low.z, 1e-4 * std::abs(expected.bounds.low.z));
}

TEST(DepthInput, DisparitiesMayReachDownToMinusDoffs) {
    const test::TemporaryFolder folder;
    std::string pgm = "P5\n60 40\n255\n";
    for (int i = 0; i < 60 * 40; ++i) pgm += static_cast<char>(20 + (i % 60) / 2);
    test::write_text(folder / "d.pgm", pgm);
    RunRequest request;
    request.disparity = folder / "d.pgm";
    request.outputs = {folder / "a.ply"};
    request.config.input.disparity.scale = 1;
    request.config.disparity.dequantize = stages::Dequantization::none;
    request.config.input.calibration.focal_px = 60;
    request.config.input.calibration.baseline_m = 0.1;
    request.config.input.calibration.doffs_px = 0;
    const RunReport expected = run_job(request, {});
    request.config.input.disparity.offset_px = -30;
    request.config.input.calibration.doffs_px = 30;
    const RunReport report = run_job(request, {});
    EXPECT_EQ(report.outputs.at(0).sha256, expected.outputs.at(0).sha256);
    EXPECT_EQ(report.calibration.doffs_px, 0);
    EXPECT_EQ(report.shares.foreground, 1);
}

// Nothing but the focal length is known: the depths stay what they are.
TEST(DepthInput, AFocalLengthIsEnoughForAMetricMesh) {
    const test::TemporaryFolder folder;
    const DepthScene scene = depth_scene();
    RunRequest request = request_for(folder);
    request.config.input.calibration = {};
    request.config.input.calibration.focal_px = scene.camera.focal_px;
    request.depth = folder / "z.pfm";
    write_floats(request.depth, scene.disparities, scene.depths);
    std::string said;
    RunObserver observer;
    observer.decides = [&](const std::string& decision) { said += decision + "\n"; };
    const RunReport report = run_job(request, observer);
    EXPECT_TRUE(report.warnings.empty()) << report.warnings.front();
    EXPECT_TRUE(report.calibration.metric);
    float nearest = kUnknownDepth;
    for (const float depth : scene.depths)
        if (depth > 0) nearest = std::min(nearest, depth);
    EXPECT_NEAR(report.calibration.baseline_m, 0.125 * nearest, 0.01 * nearest);
    EXPECT_NEAR(-report.bounds.high.z, nearest, 0.01 * nearest);
    EXPECT_NE(said.find("depth: floats, m; "), std::string::npos) << said;
    EXPECT_NE(said.find("of a baseline of"), std::string::npos) << said;
    const auto json = nlohmann::json::parse(report_json(report));
    EXPECT_EQ(json["input"]["calibration"]["baseline_m"], report.calibration.baseline_m);
    const auto& believed = json["input"]["believed"];
    EXPECT_EQ(believed["depth"], "floats, m");
    EXPECT_EQ(believed["focal"], "input.calibration.focal_px");
    EXPECT_EQ(believed["baseline"], "the nearest distance");
}

TEST(DepthInput, WithoutFocalLengthOrWithRelativeDepthsTheMeshIsRelative) {
    const test::TemporaryFolder folder;
    const DepthScene scene = depth_scene();
    RunRequest request = request_for(folder);
    request.depth = folder / "z.pfm";
    write_floats(request.depth, scene.disparities, scene.depths);
    request.config.input.calibration = {};
    const RunReport guessed = run_job(request, {});
    EXPECT_FALSE(guessed.calibration.metric);
    EXPECT_EQ(guessed.calibration.focal_px, scene.disparities.width);
    ASSERT_EQ(guessed.warnings.size(), 1u);
    EXPECT_NE(guessed.warnings[0].find("focal length"), std::string::npos) << guessed.warnings[0];
    request.config = request_for(folder).config;
    request.config.input.depth.kind = readers::DepthKind::affine_inverse;
    const RunReport relative = run_job(request, {});
    EXPECT_FALSE(relative.calibration.metric);
    EXPECT_NEAR(-relative.bounds.low.z, 10, 0.5);
}

// A black right half leaves the left one, in maps and in pairs.
TEST(MaskInput, WhatItHidesHasNoMesh) {
    const test::TemporaryFolder folder;
    const DisparityMap size = readers::read_disparity_map(test::sample("disparity.pfm"), {});
    std::string pgm =
        "P5\n" + std::to_string(size.width / 2) + " " + std::to_string(size.height / 2) + "\n255\n";
    for (int i = 0; i < size.width / 2 * (size.height / 2); ++i)
        pgm += i % (size.width / 2) < size.width / 4 ? '\xff' : '\0';
    test::write_text(folder / "mask.pgm", pgm);
    RunRequest request = request_for(folder);
    request.disparity = test::sample("disparity.pfm");
    const RunReport whole = run_job(request, {});
    request.mask = folder / "mask.pgm";
    const RunReport masked = run_job(request, {});
    EXPECT_LT(masked.bounds.high.x, 0.2 * whole.bounds.high.x);
    EXPECT_NEAR(masked.bounds.low.x, whole.bounds.low.x, 0.05 * std::abs(whole.bounds.low.x));
    EXPECT_EQ(masked.inputs.back().role, "mask");
    request.confidence = folder / "mask.pgm";
    request.mask.clear();
    EXPECT_EQ(run_job(request, {}).outputs[0].sha256, masked.outputs[0].sha256);
    request.confidence.clear();
    request.mask = folder / "mask.pgm";
    request.disparity.clear();
    request.left = test::sample("left.png");
    request.right = test::sample("right.png");
    EXPECT_LT(run_job(request, {}).bounds.high.x, 0.2 * whole.bounds.high.x);
}

TEST(MaskInput, WhatIsTransparentInThePictureIsUnknown) {
    const RunObserver observer;
    RunLog log(observer);
    RunRequest request;
    // The picture has twice the map's size; its left half is transparent.
    Image picture{4, 2, 1, std::vector<std::uint8_t>(8, 100), {0, 127, 128, 255, 0, 0, 255, 255}};
    const DisparityMap map{2, 1, {5, 6}};
    RunInput input = take_map({.disparity = map, .color = picture}, request, log);
    EXPECT_EQ(input.map.values, (std::vector<float>{kUnknownDisparity, 6}));
    EXPECT_EQ(input.mask.kept, (std::vector<std::uint8_t>{0, 1}));
    EXPECT_EQ(take_pair({picture, picture}, request, log).mask.kept,
              (std::vector<std::uint8_t>{0, 0, 1, 1, 0, 0, 1, 1}));
    request.config.input.mask.alpha = false;
    EXPECT_EQ(take_map({.disparity = map, .color = picture}, request, log).map.values, map.values);
    request.config.input.mask.alpha = true;
    picture.alpha.assign(8, 0);
    EXPECT_THROW(take_map({.disparity = map, .color = picture}, request, log), Error);
}

TEST(DepthInput, LimitsThatLeaveNothingAreRefused) {
    const test::TemporaryFolder folder;
    const DepthScene scene = depth_scene();
    RunRequest request = request_for(folder);
    request.depth = folder / "z.pfm";
    write_floats(request.depth, scene.disparities, scene.depths);
    request.config.input.depth.far_m = 1e-3;
    try {
        run_job(request, {});
        ADD_FAILURE() << "nothing was thrown";
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::input);
        EXPECT_NE(std::string(error.what()).find("near_m"), std::string::npos) << error.what();
    }
}

}  // namespace
}  // namespace hexrelief::job
