// Follows the advice of each warning: what is an error under --strict is none afterwards.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <regex>

#include "exporters/images/image_writer.h"
#include "pipeline/readers/disparity_reader.h"
#include "pipeline/readers/image_reader.h"
#include "tests/pipeline/process.h"

namespace hexrelief::cli {
namespace {

using namespace test;

using Words = std::vector<std::string>;

const std::string kLeft = sample("left.png"), kRight = sample("right.png"), kCamera = sample("calib.txt");

// Writes the sample's disparities, each changed, and the rows in the other order if `flip`.
std::string changed_map(const TemporaryFolder& folder, const std::function<float(float)>& change,
                        bool flip = false) {
    const DisparityMap map = readers::read_disparity_map(sample("disparity.pfm"), {});
    const std::string path = folder / "map.pfm";
    std::ofstream file(path, std::ios::binary);
    file << "Pf\n" << map.width << " " << map.height << "\n-1\n";
    for (int i = 0; i < map.height; ++i)
        for (int x = 0; x < map.width; ++x) {
            const float value = change(map.at(x, flip ? i : map.height - 1 - i));
            file.write(reinterpret_cast<const char*>(&value), sizeof value);
        }
    return path;
}

ProcessResult run_strictly(const TemporaryFolder& folder, const Words& options) {
    return run_program({"run", "--strict", "--set", "mesh.spacing_px=8", "-o", folder / "a.drc"}, options);
}

// The first run is refused in a line with the advice; the second one follows it.
void expect_help(const TemporaryFolder& folder, const Words& wrong, const std::string& advice,
                 const Words& right) {
    const ProcessResult refused = run_strictly(folder, wrong);
    EXPECT_EQ(refused.exit_code, 3) << advice;
    EXPECT_CONTAINS(refused.err, advice);
    const ProcessResult done = run_strictly(folder, right);
    EXPECT_EQ(done.exit_code, 0) << advice << "\n" << done.err;
}

void expect_map_help(const std::function<float(float)>& change, bool flip, const std::string& as,
                     const std::string& advice, const Words& right) {
    const TemporaryFolder folder;
    const std::string map = changed_map(folder, change, flip);
    const Words rest = {map, "--color", kLeft, "--calib", kCamera};
    expect_help(folder, test::joined({as}, rest), advice, test::joined(right, rest));
}

float depth_of(float disparity) {
    return 320 * 0.16f / disparity;
}

TEST(Advice, OnMapsHelps) {
    const auto same = [](float d) { return d; };
    expect_map_help(same, true, "--disparity", "--flip", {"--flip", "--disparity"});
    expect_map_help([](float d) { return -d; }, false, "--disparity", "--disparity-scale -1",
                    {"--disparity-scale", "-1", "--disparity"});
    expect_map_help(depth_of, false, "--disparity", "give depths with --depth", {"--depth"});
    expect_map_help(same, false, "--depth", "give disparities with --disparity", {"--disparity"});
    expect_map_help([](float d) { return 1 / depth_of(d); }, false, "--depth", "--depth-kind inverse_depth",
                    {"--depth-kind", "inverse_depth", "--depth"});
    expect_map_help([](float d) { return (d - 4) / 36; }, false, "--depth", "guess with affine_inverse",
                    {"--depth-kind", "affine_inverse", "--depth"});
    expect_map_help([](float d) { return d * 256; }, false, "--disparity", "give --disparity-scale",
                    {"--disparity-scale", "256", "--disparity"});
    expect_map_help([](float d) { return d / 256; }, false, "--disparity", "give --disparity-scale",
                    {"--disparity-scale", "0.00390625", "--disparity"});
    expect_map_help([](float d) { return 1000 * depth_of(d); }, false, "--depth", "check input.depth.unit",
                    {"--set", "input.depth.unit=mm", "--depth"});
}

TEST(Advice, OnPairsHelps) {
    const TemporaryFolder folder;
    const Words right = {"--left", kLeft, "--right", kRight, "--calib", kCamera};
    expect_help(folder, {"--left", kRight, "--right", kLeft, "--calib", kCamera},
                "exchange --left and --right", right);
    const Image left = readers::read_image(kLeft), second = readers::read_image(kRight);
    Image crossed{left.width, 2 * left.height, left.channels, second.pixels};
    crossed.pixels.insert(crossed.pixels.end(), left.pixels.begin(), left.pixels.end());
    exporters::write_png(folder / "tb.png", crossed);
    Words one_file = {"--stereo", folder / "tb.png", "--layout", "tb", "--calib", kCamera};
    expect_help(folder, one_file, "input.stereo.right_first=true",
                joined(one_file, {"--set", "input.stereo.right_first=true"}));
    expect_help(folder, {"--left", kLeft, "--right", kLeft, "--calib", kCamera},
                "give the left and the right view", right);
    const Words narrow = joined(right, {"--set", "disparity.num_disparities_px=16"});
    Words wider = joined(right, {"--set", "disparity.num_disparities_px=48"});
    expect_help(folder, narrow, "set it to 48, or to 0", wider);
    wider.back() = "disparity.num_disparities_px=0";
    expect_help(folder, narrow, "set it to 48, or to 0", wider);
}

TEST(Advice, OnCamerasHelps) {
    const TemporaryFolder folder;
    write_text(folder / "km.txt",
               std::regex_replace(read_text(kCamera), std::regex("baseline=160"), "baseline=160000"));
    const Words wrong = {"--left", kLeft, "--right", kRight, "--calib", folder / "km.txt"};
    expect_help(folder, wrong, "set input.calibration.baseline_m to 1.6 or 0.16",
                joined(wrong, {"--set", "input.calibration.baseline_m=0.16"}));
}

TEST(Advice, OnRowsHelps) {
    const TemporaryFolder folder;
    Image lower = readers::read_image(kRight);
    const auto row = static_cast<std::ptrdiff_t>(lower.width) * lower.channels;
    std::rotate(lower.pixels.begin(), lower.pixels.end() - 8 * row, lower.pixels.end());
    exporters::write_png(folder / "lower.png", lower);
    const Words wrong = {"--left", kLeft, "--right", folder / "lower.png", "--calib", kCamera};
    expect_help(folder, wrong, "--rectify always", joined(wrong, {"--rectify", "always"}));
}

}  // namespace
}  // namespace hexrelief::cli
