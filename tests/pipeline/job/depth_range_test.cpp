// Tests that a pair's mesh is about as deep as its scene.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/job/runner.h"
#include "pipeline/readers/disparity_reader.h"
#include "tests/pipeline/process.h"

namespace hexrelief::job {
namespace {

namespace fs = std::filesystem;

struct TruePair {
    const char *folder, *images, *truth, *calibration;  // images: file name extension
    double scale;
};

void PrintTo(const TruePair& pair, std::ostream* out) {
    *out << pair.folder;
}

// The 0.1st and the 99.9th percentile.
std::pair<double, double> range_of(std::vector<double> depths) {
    std::sort(depths.begin(), depths.end());
    const std::size_t least = depths.size() / 1000;
    return {depths.at(least), depths.at(depths.size() - 1 - least)};
}

void expect_range_of_truth(const fs::path& folder, const TruePair& pair) {
    RunRequest request{.source = PairFiles{folder / (std::string("left.") + pair.images),
                                           folder / (std::string("right.") + pair.images)}};
    if (pair.calibration) request.config.input.calibration.file = folder / pair.calibration;
    const test::TemporaryFolder outputs;
    request.outputs = {outputs / "a.glb"};
    const RunReport report = run_job(request);
    const Relief& relief = *report.relief;
    std::vector<double> depths;
    for (const Vec3f& position : relief.surface.mesh.positions) depths.push_back(-double(position.z));
    const auto [nearest, farthest] = range_of(std::move(depths));

    readers::DisparityFileConfig file{.scale = pair.scale};
    if (pair.scale > 1) file.unknown = 0;
    const Calibration& camera = relief.pair_camera;
    std::vector<double> true_depths;
    for (const float d : readers::read_disparity_map(folder / pair.truth, file).values)
        if (DisparityMap::known(d) && d + camera.doffs_px > 0)
            true_depths.push_back(camera.focal_px * camera.baseline_m / (d + camera.doffs_px));
    const auto [true_nearest, true_farthest] = range_of(std::move(true_depths));
    constexpr double kRatio = 1.5;
    EXPECT_GT(nearest, true_nearest / kRatio);
    EXPECT_LT(farthest, true_farthest * kRatio);
}

TEST(DepthRange, OfTheSamplesIsTheTruths) {
    expect_range_of_truth(fs::path(test::sample("left.png")).parent_path(),
                          {"samples", "png", "disparity.pfm", "calib.txt", 1});
}

class RealDepthRange : public testing::TestWithParam<TruePair> {};

TEST_P(RealDepthRange, IsTheTruths) {
    const char* const data = std::getenv("HEXRELIEF_DATA");
    if (data == nullptr) GTEST_SKIP() << "HEXRELIEF_DATA is not set: no real pairs to mesh";
    expect_range_of_truth(fs::path(data) / GetParam().folder, GetParam());
}

INSTANTIATE_TEST_SUITE_P(
    Middlebury, RealDepthRange,
    testing::Values(TruePair{"middlebury2001/tsukuba", "png", "disp.pgm", nullptr, 16},
                    TruePair{"middlebury2001/venus", "ppm", "disp.pgm", nullptr, 8},
                    TruePair{"middlebury2003/cones-quarter", "png", "disp.png", nullptr, 4},
                    TruePair{"middlebury2003/teddy-quarter", "png", "disp.png", nullptr, 4},
                    TruePair{"middlebury2006/aloe-third", "png", "disp.png", nullptr, 3},
                    TruePair{"middlebury2006/rocks1-third", "png", "disp.png", nullptr, 3},
                    TruePair{"middlebury2014-quarter/Piano", "png", "disp.pfm", "calib.txt", 1}));

}  // namespace
}  // namespace hexrelief::job
