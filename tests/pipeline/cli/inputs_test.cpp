// The main README's table of inputs, on the files of samples/inputs.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/pipeline/process.h"

namespace hexrelief::cli {
namespace {

using namespace test;

namespace fs = std::filesystem;

const fs::path kInputs = sample("inputs");

// What stands between the first two backticks of each row, as words; a name of a file becomes its path.
std::vector<std::vector<std::string>> commands_of_table() {
    std::istringstream readme(read_text(kInputs.parent_path().parent_path() / "README.md"));
    std::vector<std::vector<std::string>> commands;
    bool in_table = false;
    for (std::string line; std::getline(readme, line);) {
        if (line.starts_with("## ")) in_table = line == "## You have, you type";
        const std::size_t from = line.find("| `--");
        if (!in_table || from == std::string::npos) continue;
        std::istringstream text(line.substr(from + 3, line.find('`', from + 3) - from - 3));
        std::vector<std::string> words;
        for (std::string word; text >> word;)
            words.push_back(fs::exists(kInputs / word) ? (kInputs / word).string() : word);
        commands.push_back(std::move(words));
    }
    return commands;
}

// The other inputs, with paths.
std::vector<std::vector<std::string>> more_commands() {
    const std::string camera = kInputs / "foundation.txt", left = kInputs / "left.png";
    return {{"--stereo", kInputs / "pair.jps", "--calib", camera},
            {"--left", kInputs / "left.bmp", "--right", kInputs / "right.bmp", "--calib", camera},
            {"--depth", kInputs / "depth.npy", "--color", kInputs / "turned.jpg", "--calib", camera},
            {"--stereo", kInputs / "side_by_side_half.jpg", "--layout", "sbs-half", "--calib", camera},
            {"--stereo", kInputs / "top_bottom.jpg", "--layout", "tb", "--calib", camera},
            {"--depth", kInputs / "depth.npy", "--confidence", kInputs / "confidence.png", "--color", left,
             "--calib", kInputs / "camera_info.yaml"},
            {"--disparity", kInputs / "sgbm.png", "--color", left, "--calib", camera},
            {"--disparity", kInputs / "negative.npy", "--disparity-scale", "-1", "--color", left, "--calib",
             camera},
            {"--depth", kInputs / "carla.png", "--packed", "carla", "--color", left, "--calib",
             kInputs / "transforms.json"},
            {"--depth", kInputs / "colmap.bin", "--depth-unit", "m", "--color", left, "--calib", camera},
            {"--disparity", kInputs / "sintel.png", "--packed", "sintel", "--color", left, "--calib", camera},
            {"--depth", kInputs / "000003.png", "--color", left, "--calib", kInputs / "scene_camera.json"},
            {"--left", left, "--right", kInputs / "right.png", "--calib", kInputs / "oak.json"},
            {"--left", left, "--right", kInputs / "right.png", "--calib", kInputs / "left.yaml"},
            {"--left", left, "--right", kInputs / "right.png", "--calib", kInputs / "camchain.yaml"},
            {"--left", left, "--right", kInputs / "right.png", "--calib", kInputs / "rig.npz"}};
}

TEST(Inputs, EachMeshesTheSameScene) {
    std::vector<std::vector<std::string>> commands = commands_of_table();
    ASSERT_GE(commands.size(), 12u);
    for (std::vector<std::string>& command : more_commands()) commands.push_back(std::move(command));
    for (const std::vector<std::string>& options : commands) {
        const TemporaryFolder folder;
        std::string shown;
        for (const std::string& word : options) shown += word + " ";
        const ProcessResult result = run_program({"run", "-o", folder / "a.glb", "--report", "-"}, options);
        ASSERT_EQ(result.exit_code, 0) << shown << result.err;
        const nlohmann::json report = nlohmann::json::parse(result.out);
        const bool says_cm = shown.find("oak.json") != std::string::npos;
        EXPECT_EQ(report["warnings"].size(), says_cm ? 1u : 0u) << shown << result.err;
        EXPECT_GT(report["picture"]["meshed_share"], 0.5) << shown;
        const bool of_colmap = shown.find("colmap.bin") != std::string::npos;
        const bool relative = shown.find("affine_") != std::string::npos ||
                              (of_colmap && shown.find("--depth-unit") == std::string::npos);
        EXPECT_EQ(report["surface"]["metric"].get<bool>(), !relative) << shown;
        if (relative) continue;
        // The nearest sphere, and no nearer.
        EXPECT_NEAR(report["depth_range"][0].get<double>(), 1.29, 0.1) << shown;
        EXPECT_LT(report["depth_range"][1].get<double>(), 1.5 * 12.3)
            << shown << "the horizon is 12.3 m away";
    }
}

TEST(Inputs, ASpatialPhotographTellsItsCameraByItself) {
    const TemporaryFolder folder;
    const std::string photograph = kInputs / "spatial.heic";
    const ProcessResult told = run_program({"info", photograph});
    if (told.err.find("libheif-dev") != std::string::npos) GTEST_SKIP() << "built without libheif";
    EXPECT_CONTAINS(told.out, "two views of 80 x 60 px");
    EXPECT_CONTAINS(told.out, "80 x 60 px, left view");
    EXPECT_CONTAINS(told.out, "focal 80 px, baseline 0.16 m");
    const ProcessResult run =
        expect_success({"run", "--strict", "--stereo", photograph, "-o", folder / "a.glb", "--report", "-"});
    const nlohmann::json report = nlohmann::json::parse(run.out);
    EXPECT_TRUE(report["surface"]["metric"].get<bool>());
    EXPECT_NEAR(report["depth_range"][0].get<double>(), 1.29, 0.1);
    EXPECT_CONTAINS(run.err, "the photograph's own camera");
}

TEST(Inputs, APictureIsTurnedByItsOrientationUnlessThatIsOff) {
    const std::string left = kInputs / "turned.jpg";
    EXPECT_CONTAINS(run_program({"info", left}).out, "turned by a quarter clockwise");
    const TemporaryFolder folder;
    const std::vector<std::string> run = {
        "run", "--depth",       kInputs / "depth.npy", "--color", left, "--calib", kInputs / "foundation.txt",
        "-o",  folder / "a.glb"};
    expect_success(run);
    expect_failure(joined(run, {"--set", "input.exif_orientation=false"}), 3, "same aspect");
}

TEST(Inputs, InfoTellsTheCameraInAnArchive) {
    const std::string told = run_program({"info", kInputs / "rig.npz"}).out;
    EXPECT_CONTAINS(told, "K: 3 x 3");
    EXPECT_CONTAINS(told, "0.16 m");
    EXPECT_EQ(told.find("cannot read"), std::string::npos) << told;
}

TEST(Inputs, OnePictureTwiceIsAnErrorWhereStrict) {
    const TemporaryFolder folder;
    const std::string left = kInputs / "left.png";
    const ProcessResult result =
        run_program({"run", "--left", left, "--right", left, "--strict", "-o", folder / "a.glb"});
    EXPECT_EQ(result.exit_code, 3);
    EXPECT_CONTAINS(result.err, "the same picture");
}

TEST(Inputs, TheProgramsOwnMapOfThemIsNotSuspected) {
    const TemporaryFolder folder;
    expect_success({"run", "--left", kInputs / "left.png", "--right", kInputs / "right.png", "--save-stages",
                    folder / "s"});
    expect_success({"run", "--disparity", folder / "s/disparity.pfm", "--strict", "-o", folder / "a.glb"});
}

}  // namespace
}  // namespace hexrelief::cli
