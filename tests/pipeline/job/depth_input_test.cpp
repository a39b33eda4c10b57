// Depth maps through whole jobs, against the disparity map that they were made from.
#include "pipeline/job/maps/disparity_input.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "pipeline/data/error.h"
#include "pipeline/job/runner.h"
#include "pipeline/readers/cameras/calibration_reader.h"
#include "pipeline/readers/disparity_reader.h"
#include "tests/pipeline/process.h"

namespace hexrelief::job {
namespace {

namespace fs = std::filesystem;

struct DepthScene {
    Calibration camera;
    DisparityMap disparities;
    std::vector<float> depths;  // 0 = unknown
};

// The synthetic pair's.
DepthScene depth_scene() {
    DepthScene scene{readers::read_calibration_file(test::sample("calib.txt")).calibration,
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

// The scene's depths as a file.
DepthFiles depth_file(const test::TemporaryFolder& folder, const DepthScene& scene) {
    write_floats(folder / "z.pfm", scene.disparities, scene.depths);
    return {folder / "z.pfm"};
}

double triangles(const RunReport& report) {
    return static_cast<double>(report.relief->surface.mesh.triangles.size());
}

Bounds bounds(const RunReport& report) {
    return report.relief->surface.bounds;
}

RunRequest request_for(const test::TemporaryFolder& folder) {
    return {
        .outputs = {folder / "a.ply"},
        .config = {.input = {.calibration = {.file = test::sample("calib.txt")}}, .mesh = {.spacing_px = 8}},
        .report = folder / "r.json"};
}

TEST(DepthInput, ADepthMapGivesTheMeshOfItsDisparityMap) {
    const test::TemporaryFolder folder;
    const DepthScene scene = depth_scene();
    RunRequest request = request_for(folder);
    request.source = DisparityFiles{test::sample("disparity.pfm")};
    const RunReport expected = run_job(request);
    request.source = depth_file(folder, scene);
    const RunReport report = run_job(request);
    const RunInput& input = report.relief->input;
    EXPECT_EQ(input.files.front().role, "depth");
    EXPECT_EQ(input.calibration.baseline_m, scene.camera.baseline_m);
    EXPECT_TRUE(input.calibration.metric);
    EXPECT_NEAR(triangles(report), triangles(expected), 0.002 * triangles(expected));
    EXPECT_NEAR(report.quality.rmse_near_px, expected.quality.rmse_near_px, 0.01);
    const Bounds there = bounds(report), here = bounds(expected);
    EXPECT_NEAR(there.low.z, here.low.z, 1e-3 * std::abs(here.low.z));
    EXPECT_NEAR(there.high.x, here.high.x, 1e-3 * std::abs(here.high.x));
}

// The camera's doffs says nothing about depths.
TEST(DepthInput, FarDepthsAreThereWhateverTheDoffs) {
    const test::TemporaryFolder folder;
    const DepthScene scene = depth_scene();
    RunRequest request = request_for(folder);
    request.source = depth_file(folder, scene);
    request.config.input.calibration.doffs_px = 0;
    const RunReport expected = run_job(request);
    request.config.input.calibration.doffs_px = 100;
    const RunReport report = run_job(request);
    EXPECT_EQ(report.relief->input.calibration.doffs_px, 0);
    EXPECT_NEAR(triangles(report), triangles(expected), 3);
    const double deepest = bounds(expected).low.z;
    EXPECT_NEAR(bounds(report).low.z, deepest, 1e-4 * std::abs(deepest));
}

TEST(DepthInput, DisparitiesMayReachDownToMinusDoffs) {
    const test::TemporaryFolder folder;
    std::string pgm = "P5\n60 40\n255\n";
    for (int i = 0; i < 60 * 40; ++i) pgm += static_cast<char>(20 + (i % 60) / 2);
    test::write_text(folder / "d.pgm", pgm);
    RunRequest request{
        .source = DisparityFiles{folder / "d.pgm"},
        .outputs = {folder / "a.ply"},
        .config = {.input = {.disparity = {.scale = 1},
                             .calibration = {.focal_px = 60, .baseline_m = 0.1, .doffs_px = 0}},
                   .disparity = {.dequantize = stages::Dequantization::none}}};
    const RunReport expected = run_job(request);
    request.config.input.disparity.offset_px = -30;
    request.config.input.calibration.doffs_px = 30;
    const RunReport report = run_job(request);
    EXPECT_EQ(report.outputs.at(0).sha256, expected.outputs.at(0).sha256);
    EXPECT_EQ(report.relief->input.calibration.doffs_px, 0);
    EXPECT_EQ(report.shares.foreground, 1);
}

// Nothing but the focal length is known: the depths stay what they are.
TEST(DepthInput, AFocalLengthIsEnoughForAMetricMesh) {
    const test::TemporaryFolder folder;
    const DepthScene scene = depth_scene();
    RunRequest request = request_for(folder);
    request.config.input.calibration = {.focal_px = scene.camera.focal_px};
    request.source = depth_file(folder, scene);
    std::string said;
    RunLog log;
    log.decides = [&](const std::string& decision) { said += decision + "\n"; };
    Backends backends;
    const RunReport report = run_job(request, backends, log);
    EXPECT_TRUE(report.warnings.empty()) << report.warnings.front();
    EXPECT_TRUE(report.relief->input.calibration.metric);
    float nearest = kUnknownDepth;
    for (const float depth : scene.depths)
        if (depth > 0) nearest = std::min(nearest, depth);
    EXPECT_NEAR(report.relief->input.calibration.baseline_m, 0.125 * nearest, 0.01 * nearest);
    EXPECT_NEAR(-bounds(report).high.z, nearest, 0.01 * nearest);
    EXPECT_CONTAINS(said, "depth: floats, m; ");
    EXPECT_CONTAINS(said, "of a baseline of");
    const auto json = nlohmann::json::parse(report_json(report));
    EXPECT_EQ(json["input"]["calibration"]["baseline_m"], report.relief->input.calibration.baseline_m);
    const auto& believed = json["input"]["believed"];
    EXPECT_EQ(believed["depth"], "floats, m");
    EXPECT_EQ(believed["focal"], "input.calibration.focal_px");
    EXPECT_EQ(believed["baseline"], "the nearest distance");
}

TEST(DepthInput, WithoutFocalLengthOrWithRelativeDepthsTheMeshIsRelative) {
    const test::TemporaryFolder folder;
    const DepthScene scene = depth_scene();
    RunRequest request = request_for(folder);
    request.source = depth_file(folder, scene);
    request.config.input.calibration = {};
    const RunReport guessed = run_job(request);
    EXPECT_FALSE(guessed.relief->input.calibration.metric);
    EXPECT_EQ(guessed.relief->input.calibration.focal_px, scene.disparities.width);
    ASSERT_EQ(guessed.warnings.size(), 1u);
    EXPECT_CONTAINS(guessed.warnings[0], "focal length");
    request.config = request_for(folder).config;
    request.config.input.depth.kind = readers::DepthKind::affine_inverse;
    const RunReport relative = run_job(request);
    EXPECT_FALSE(relative.relief->input.calibration.metric);
    EXPECT_NEAR(-bounds(relative).low.z, 10, 0.5);
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
    const fs::path map = test::sample("disparity.pfm"), mask = folder / "mask.pgm";
    request.source = DisparityFiles{map};
    const Bounds whole = bounds(run_job(request));
    request.source = DisparityFiles{.map = map, .mask = mask};
    const RunReport masked = run_job(request);
    EXPECT_LT(bounds(masked).high.x, 0.2 * whole.high.x);
    EXPECT_NEAR(bounds(masked).low.x, whole.low.x, 0.05 * std::abs(whole.low.x));
    EXPECT_EQ(masked.relief->input.files.back().role, "mask");
    request.source = DisparityFiles{.map = map, .confidence = mask};
    EXPECT_EQ(run_job(request).outputs[0].sha256, masked.outputs[0].sha256);
    request.source = PairFiles{test::sample("left.png"), test::sample("right.png"), mask};
    const RunReport pair = run_job(request);
    EXPECT_LT(bounds(pair).high.x, 0.2 * whole.high.x);
    EXPECT_TRUE(pair.relief->input.pair()->is_masked);
    std::replace(pgm.begin(), pgm.end(), '\0', '\xff');
    test::write_text(mask, pgm);
    EXPECT_FALSE(run_job(request).relief->input.pair()->is_masked) << "it hides nothing";
}

TEST(MaskInput, WhatIsTransparentInThePictureIsUnknown) {
    RunLog log;
    config::InputConfig config;
    const auto read = [&](const Source& source) { return read_input(source, config, {}, 1, log); };
    // The picture has twice the map's size; its left half is transparent.
    Image picture{4, 2, 1, std::vector<std::uint8_t>(8, 100), {0, 127, 128, 255, 0, 0, 255, 255}};
    const DisparityMap map{2, 1, {5, 6}};
    const RunInput input = read(DisparityArrays{{map}, picture});
    EXPECT_EQ(input.map()->disparities.values, (std::vector<float>{kUnknownDisparity, 6}));
    EXPECT_EQ(input.mask.kept, (std::vector<std::uint8_t>{0, 1}));
    const RunInput pair = read(PairArrays{{picture, picture}});
    EXPECT_EQ(pair.mask.kept, (std::vector<std::uint8_t>{0, 0, 1, 1, 0, 0, 1, 1}));
    EXPECT_TRUE(pair.pair()->is_masked);
    config.mask.alpha = false;
    EXPECT_FALSE(read(PairArrays{{picture, picture}}).pair()->is_masked);
    EXPECT_EQ(read(DisparityArrays{{map}, picture}).map()->disparities.values, map.values);
    config.mask.alpha = true;
    picture.alpha.assign(8, 0);
    EXPECT_THROW(read(DisparityArrays{{map}, picture}), Error);
}

TEST(DepthInput, LimitsThatLeaveNothingAreRefused) {
    const test::TemporaryFolder folder;
    const DepthScene scene = depth_scene();
    RunRequest request = request_for(folder);
    request.source = depth_file(folder, scene);
    request.config.input.depth.far_m = 1e-3;
    EXPECT_CONTAINS(test::error_of([&] { run_job(request); }), "near_m");
}

}  // namespace
}  // namespace hexrelief::job
