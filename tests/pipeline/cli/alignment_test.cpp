// Pairs of made-up cameras that were never rectified, through the command line.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "pipeline/data/crop.h"
#include "tests/pipeline/alignment/turned_pair.h"
#include "tests/pipeline/process.h"

namespace hexrelief::cli {
namespace {

using namespace test;
using alignment::render_pair;
using alignment::TurnedCameras;

void write_picture(const std::string& path, const Image& image) {
    write_text(path, "P5\n" + std::to_string(image.width) + " " + std::to_string(image.height) + "\n255\n" +
                         std::string(image.pixels.begin(), image.pixels.end()));
}

// Runs on a pair with more options, and expects an exit code. Returns the run; its report is in the folder.
ProcessResult run_on(const StereoPair& pair, const TemporaryFolder& folder,
                     const std::vector<std::string>& options, int exit_code = 0) {
    write_picture(folder / "left.pgm", pair.left);
    write_picture(folder / "right.pgm", pair.right);
    ProcessResult result = run_program({"run", "--left", folder / "left.pgm", "--right", folder / "right.pgm",
                                        "-o", folder / "o.glb", "--report", folder / "r.json"},
                                       options);
    EXPECT_EQ(result.exit_code, exit_code) << result.err;
    return result;
}

nlohmann::json report_in(const TemporaryFolder& folder) {
    return nlohmann::json::parse(read_text(folder / "r.json"));
}

const TurnedCameras kTurned{.pitch = 3, .yaw = 2, .roll = 2, .common_yaw = 1};
const double kFovX_deg = 2 * std::atan(320 / kTurned.focal_px) * 180 / std::acos(-1.0);

TEST(Alignment, AnUnrectifiedPairIsMeshedInMetres) {
    const TemporaryFolder folder;
    const ProcessResult result =
        run_on(render_pair(kTurned), folder,
               {"--fov-x", std::to_string(kFovX_deg), "--set", "input.calibration.baseline_m=0.15",
                "--save-stages", folder / "stages", "--strict"});
    EXPECT_CONTAINS(result.out + result.err, "aligned: rows were off by");
    const nlohmann::json report = report_in(folder);
    const nlohmann::json& alignment = report["input"]["alignment"];
    EXPECT_TRUE(alignment["aligned"].get<bool>());
    EXPECT_LT(alignment["rows_held_out"]["median_px"].get<double>(), 0.15);
    EXPECT_NEAR(alignment["angles_deg"]["pitch"].get<double>(), kTurned.pitch, 0.1);
    EXPECT_TRUE(report["surface"]["metric"].get<bool>());
    // Boards from 2 m on before a wall at 6 m; the mesh ends where both pictures do.
    EXPECT_NEAR(report["depth_range"][0].get<double>(), 2, 0.2);
    EXPECT_NEAR(report["depth_range"][1].get<double>(), 6, 1);
    EXPECT_GT(report["picture"]["meshed_share"].get<double>(), 0.8);
    EXPECT_GT(report["config"]["surface"]["behind"].get<double>(), 5) << "a turn by 20 degrees looks so far";
    EXPECT_TRUE(std::filesystem::exists(folder / "stages/left_rectified.png"));
    // The report's camera is that of the rectified pictures.
    const std::string camera = read_text(folder / "stages/calib.txt"), key = "doffs_px: ";
    const double doffs_px = std::stod(camera.substr(camera.find(key) + key.size()));
    EXPECT_GT(doffs_px, 1);
    EXPECT_EQ(report["input"]["calibration"]["doffs_px"].get<double>(), doffs_px);
}

TEST(Alignment, WithoutACameraTheMedianDepthIsOne) {
    const TemporaryFolder folder;
    run_on(render_pair(kTurned), folder, {"--set", "surface.behind=2"});
    const nlohmann::json report = report_in(folder);
    EXPECT_FALSE(report["surface"]["metric"].get<bool>());
    EXPECT_EQ(report["config"]["surface"]["behind"], 2) << "as it was given";
    EXPECT_GT(report["depth_range"][0].get<double>(), 0.3);
    EXPECT_LT(report["depth_range"][0].get<double>(), 1);
    EXPECT_GT(report["depth_range"][1].get<double>(), 1);
}

TEST(Alignment, NeverLeavesThePairAsItIs) {
    const TemporaryFolder folder;
    const ProcessResult result = run_on(render_pair(kTurned), folder, {"--rectify", "never"});
    EXPECT_CONTAINS(result.err, "rows differ");
    EXPECT_TRUE(report_in(folder)["input"]["alignment"].is_null());
}

TEST(Alignment, ARectifiedPairHasTheSameBytesAsWithNever) {
    const StereoPair pair = render_pair({});
    const TemporaryFolder automatic, never;
    run_on(pair, automatic, {});
    run_on(pair, never, {"--set", "input.rectify=never"});
    EXPECT_FALSE(report_in(automatic)["input"]["alignment"]["aligned"].get<bool>());
    // Only the key itself is in the file.
    EXPECT_EQ(report_in(automatic)["surface"], report_in(never)["surface"]);
}

TEST(Alignment, NegativeDisparitiesAreSearched) {
    // A stereo window: both pictures are cut so that things at 3 m have a disparity of 0.
    StereoPair pair = render_pair({});
    const int shift = 29;
    for (Image* image : {&pair.left, &pair.right}) {
        Image cut{image->width - shift, image->height, 1, {}};
        const int from = image == &pair.left ? shift : 0;
        for (int y = 0; y < cut.height; ++y)
            cut.pixels.insert(cut.pixels.end(), image->at(from, y), image->at(from, y) + cut.width);
        *image = std::move(cut);
    }
    const TemporaryFolder folder;
    const ProcessResult result = run_on(pair, folder, {});
    EXPECT_EQ(result.err.find("lie below the range"), std::string::npos) << result.err;
    EXPECT_CONTAINS(result.err, "where infinity lies is not known");
    const nlohmann::json report = report_in(folder);
    EXPECT_LT(report["disparity"]["min_disparity_px"].get<int>(), -14);
    EXPECT_GT(report["picture"]["meshed_share"].get<double>(), 0.8);
}

TEST(Alignment, InfoTellsWhatARunWouldDoWithTwoPictures) {
    const TemporaryFolder folder;
    const auto told = [&](const StereoPair& pair) {
        write_picture(folder / "l.pgm", pair.left);
        write_picture(folder / "r.pgm", pair.right);
        return expect_success({"info", folder / "l.pgm", folder / "r.pgm"}).out;
    };
    const auto has = [](const std::string& text, const char* part) {
        return text.find(part) != std::string::npos;
    };
    const std::string turned = told(render_pair(kTurned));
    EXPECT_TRUE(has(turned, "left          pgm, 640 x 480 px\n")) << turned;
    EXPECT_TRUE(has(turned, "a run         aligned: rows were off by")) << turned;
    EXPECT_TRUE(has(turned, "mask: keeps")) << turned;
    EXPECT_TRUE(has(turned, "both pictures show; relative units")) << turned;
    EXPECT_TRUE(has(told(render_pair({})), "a run         alignment: none, rows are off by"));
    const std::string refused = told(render_pair({.pitch = 2, .yaw = 3, .baseline = 0}));
    EXPECT_TRUE(has(refused, "it refuses    ") && has(refused, "the camera was turned, not moved"))
        << refused;
    expect_failure({"info", folder / "l.pgm", folder / "none.pgm"}, 3, "none.pgm: no such file");
    expect_failure({"info", folder / "l.pgm", sample("calib.txt")}, 3, "no picture");
}

TEST(Alignment, InfoNoticesThatAPictureHoldsBothViews) {
    const TemporaryFolder folder;
    const StereoPair pair = render_pair(kTurned);
    // In colour, because grey files may be maps.
    const auto write = [&](const std::vector<const Image*>& views, const char* name) {
        std::string colors;
        for (int y = 0; y < pair.left.height; ++y)
            for (const Image* view : views)
                for (int x = 0; x < view->width; ++x) colors.append(3, static_cast<char>(*view->at(x, y)));
        write_text(folder / name, "P6\n" + std::to_string(views.size() * pair.left.width) + " " +
                                      std::to_string(pair.left.height) + "\n255\n" + colors);
    };
    write({&pair.left, &pair.right}, "both.ppm");
    const std::string told = run_program({"info", folder / "both.ppm"}).out;
    EXPECT_CONTAINS(told, "with --layout sbs: its halves show one scene");
    EXPECT_CONTAINS(told, "aligned: rows were off by");
    write({&pair.left, &pair.right}, "both-sbs.ppm");
    const std::string named = run_program({"info", folder / "both-sbs.ppm"}).out;
    EXPECT_CONTAINS(named, "as its name says: its halves show one scene");
    EXPECT_EQ(named.find("--layout"), std::string::npos) << named;
    write({&pair.left}, "one.ppm");
    EXPECT_EQ(run_program({"info", folder / "one.ppm"}).out.find("as stereo"), std::string::npos);
}

TEST(Alignment, AMaskForAPairThatHasToBeAlignedIsRefusedInOneLine) {
    const TemporaryFolder folder;
    const StereoPair pair = render_pair(kTurned);
    write_picture(folder / "mask.pgm", {640, 480, 1, std::vector<std::uint8_t>(640 * 480, 255)});
    const ProcessResult result = run_on(pair, folder, {"--mask", folder / "mask.pgm"}, 3);
    EXPECT_CONTAINS(result.err, "the mask is for the left picture as it is, but the pair has to be aligned");
}

TEST(Alignment, TwoFilesThatAreShiftedForAStereoWindowKeepTheirOrder) {
    const TemporaryFolder folder;
    const auto told = [&](const TurnedCameras& cameras, int shift) {
        const StereoPair pair = render_pair(cameras);
        write_picture(folder / "l.pgm", cropped(pair.left, {shift, 0, 640 - shift, 480}));
        write_picture(folder / "r.pgm", cropped(pair.right, {0, 0, 640 - shift, 480}));
        return run_program({"info", folder / "l.pgm", folder / "r.pgm"}).out;
    };
    for (const double pitch : {0.3, 3.0})
        EXPECT_CONTAINS(told({.pitch = pitch}, 60), "taken for a pair shifted for a stereo window");
}

TEST(Alignment, APictureThatWasCroppedIsAlignedWithTheWholeOtherOne) {
    const TemporaryFolder folder;
    const StereoPair pair = render_pair(kTurned);
    const ProcessResult run = run_on({pair.left, cropped(pair.right, {64, 40, 576, 440})}, folder,
                                     {"--fov-x", std::to_string(kFovX_deg)});
    EXPECT_CONTAINS(run.err, "the left picture is cut to the middle 576x440");
    const nlohmann::json report = report_in(folder);
    EXPECT_LT(report["input"]["alignment"]["rows_held_out"]["median_px"].get<double>(), 0.3);
    EXPECT_NEAR(report["input"]["calibration"]["focal_px"].get<double>(), kTurned.focal_px, 1)
        << "of the whole picture";
}

TEST(Alignment, PicturesOfTwoSizesAreRefusedUnlessTheyAreAligned) {
    const TemporaryFolder folder;
    write_text(folder / "calib.txt", "focal_px: 576\nbaseline_m: 0.15\n");
    write_picture(folder / "mask.pgm", render_pair(kTurned).left);
    const auto refusal = [&](const TurnedCameras& cameras, const PixelRect& part,
                             const std::vector<std::string>& options = {}) {
        const StereoPair pair = render_pair(cameras);
        return run_on({pair.left, cropped(pair.right, part)}, folder, options, 3).err;
    };
    constexpr PixelRect kPart{64, 40, 576, 440};
    const std::string differ = "the pair's sizes differ: ";
    EXPECT_CONTAINS(refusal(kTurned, {0, 0, 320, 240}), differ) << "more than a fifth";
    EXPECT_CONTAINS(refusal({}, {64, 0, 576, 480}), differ) << "rectified";
    EXPECT_CONTAINS(refusal(kTurned, kPart, {"--rectify", "always", "--calib", folder / "calib.txt"}),
                    differ);
    EXPECT_CONTAINS(refusal(kTurned, kPart, {"--mask", folder / "mask.pgm"}), "one size, as a mask needs");
}

TEST(Alignment, APairThatCannotBeAlignedIsAnErrorOfOneLine) {
    const TemporaryFolder folder;
    write_picture(folder / "l.pgm", render_pair({.pitch = 2, .yaw = 3, .baseline = 0}).left);
    write_picture(folder / "r.pgm", render_pair({.pitch = 2, .yaw = 3, .baseline = 0}).right);
    expect_failure({"run", "--left", folder / "l.pgm", "--right", folder / "r.pgm", "-o", folder / "o.glb"},
                   3, "the pair cannot be aligned: the camera was turned, not moved");
    EXPECT_FALSE(std::filesystem::exists(folder / "o.glb"));
}

}  // namespace
}  // namespace hexrelief::cli
