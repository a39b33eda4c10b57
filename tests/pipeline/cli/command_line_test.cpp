// The built program: help, errors and exit codes.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "tests/pipeline/process.h"

namespace hexrelief::cli {
namespace {

using namespace test;

using Arguments = std::vector<std::string>;

TEST(CommandLine, HelpHasExamplesOnEveryLevel) {
    for (const Arguments& command : {Arguments{},
                                     {"run"},
                                     {"config"},
                                     {"config", "show"},
                                     {"config", "check"},
                                     {"config", "schema"},
                                     {"info"},
                                     {"evaluate"},
                                     {"gallery"},
                                     {"devices"},
                                     {"demo"},
                                     {"manual"},
                                     {"completion"},
                                     {"batch"},
                                     {"tiles"},
                                     {"tiles", "plan"}}) {
        const ProcessResult result = expect_success(command, {"--help"});
        EXPECT_EQ(result.err, "");
        EXPECT_CONTAINS(result.out, "Example");
    }
}

TEST(CommandLine, VersionIsPrinted) {
    const ProcessResult result = expect_success({"--version"});
    EXPECT_EQ(result.out, "hexrelief " HEXRELIEF_VERSION "\n");
}

TEST(CommandLine, UsageErrorsExitWith2) {
    const TemporaryFolder folder;
    const std::string out = folder / "o.glb", left = sample("left.png"), right = sample("right.png"),
                      map = sample("disparity.pfm");
    expect_failure({}, 2, "subcommand");
    expect_failure({"rnu"}, 2, "did you mean 'run'");
    expect_failure({"run", "--lefft", left}, 2, "did you mean '--left'");
    expect_failure({"run", "-o", out}, 2, "--left");
    expect_failure({"run", "--left", left, "-o", out}, 2, "--right");
    expect_failure({"run", "--right", right, "-o", out}, 2, "--left");
    expect_failure({"run", "--left", left, "--right", right, "--disparity", map, "-o", out}, 2, "not both");
    expect_failure({"run", "--left", left, "--disparity", map, "-o", out}, 2, "give --color " + left);
    expect_failure(pair_arguments({"-o", "-", "--report", "-"}), 2, "standard output takes one file");
    expect_failure(pair_arguments({"-o", "obj:-"}), 2, "standard output takes one file");
    expect_failure({"run", "--left", left, "--right", right, "--color", left, "-o", out}, 2, "--color");
    expect_failure({"run", "--disparity", map, "--depth", map, "-o", out}, 2, "not both");
    expect_failure({"run", "--disparity", map, "--depth-unit", "mm", "-o", out}, 2, "--depth-unit");
    expect_failure({"run", "--depth", map, "--depth-unit", "cm", "-o", out}, 2, "input.depth.unit");
    expect_failure({"run", "--left", left, "--right", right, "--disparity-scale", "4", "-o", out}, 2,
                   "--disparity-scale");
    expect_failure(pair_arguments({"-o", out, "--key", "depth"}), 2,
                   "--key goes with --disparity or --depth");
    expect_failure({"run", "--left", left, "--right", right}, 2, "no output");
    expect_failure(pair_arguments({"--report", folder / "r.json", "--max-bytes", "9000"}), 2, "give -o FILE");
    expect_failure(pair_arguments({"-o", folder / "o.none"}), 2, ".glb");
    expect_failure(pair_arguments({"-o", folder / "noextension"}), 2, ".glb");
    expect_failure(pair_arguments({"-o", out, "-o", folder / "./o.glb"}), 2, "one file");
    expect_failure(pair_arguments({"-o", out, "--report", out}), 2, "report");
    expect_failure(pair_arguments({"-o", out, "--threads", "many"}), 2, "--threads");
    expect_failure(pair_arguments({"-o", out, "--threads", "-1"}), 2, "--threads");
    expect_failure(pair_arguments({"-o", out, "--seed", "-1"}), 2, "--seed");
    expect_failure(pair_arguments({"-o", out, "--backend", "gpu"}), 2, "one of auto, cpu, cuda");
    expect_failure(pair_arguments({"-o", out, "--quiet", "--verbose"}), 2, "--quiet");
    expect_failure(pair_arguments({"-o", out, "stray"}), 2, "stray");
    expect_failure(pair_arguments({"-o", out, "--set", "mesh.spacing=3"}), 2, "mesh.spacing_px");
    expect_failure(pair_arguments({"-o", out, "--set", "mesh.spacing_px=1"}), 2, "from 2 to 256");
    expect_failure(pair_arguments({"-o", out, "--config", folder / "none.yaml"}), 2, "none.yaml");
    expect_failure({"config", "check", folder / "none.yaml"}, 2, "none.yaml; check its name\n");
    expect_failure(pair_arguments({"-o", out, "--set", "mesh.spacing_px=200"}), 2, "mesh.spacing_px: 200 is");
    expect_failure(pair_arguments({"-o", out, "--set", "input.calibration.cx=1e4"}), 3, "(10000, ");
    EXPECT_EQ(folder.entries(), 0);
}

TEST(CommandLine, NoMeshGoesToATerminal) {
    const int terminal = posix_openpt(O_RDWR | O_NOCTTY);
    ASSERT_TRUE(terminal >= 0 && grantpt(terminal) == 0 && unlockpt(terminal) == 0);
    EXPECT_EQ(run_program_into(ptsname(terminal), pair_arguments({"-o", "-"})), 2);
    close(terminal);
}

TEST(CommandLine, ConfigErrorsNameFileAndLine) {
    const TemporaryFolder folder;
    write_text(folder / "bad.yaml", "mesh:\n  sped: 4\n");
    expect_failure({"config", "check", folder / "bad.yaml"}, 2,
                   "bad.yaml:2: unknown key 'mesh.sped' (did you mean 'mesh.seed'?)");
    expect_failure(pair_arguments({"-o", folder / "o.glb", "--config", folder / "bad.yaml"}), 2,
                   "bad.yaml:2:");
}

TEST(CommandLine, InputErrorsExitWith3) {
    const TemporaryFolder folder;
    const std::string out = folder / "o.glb", left = sample("left.png"), map = sample("disparity.pfm");
    write_text(folder / "text.png", "this is no image");
    write_text(folder / "small.pgm", "P5\n20 20\n255\n" + std::string(400, 'x'));
    write_text(folder / "calib.txt",
               "cam0=[1000 0 99.5; 0 1000 49.5; 0 0 1]\ncam1=[1000 0 99.5; 0 1000 49.5; 0 0 1]\n"
               "doffs=0\nbaseline=200\nwidth=33\nheight=44\n");
    expect_failure({"run", "--left", folder / "none.png", "--right", left, "-o", out}, 3, "none.png");
    expect_failure({"run", "--left", folder / "text.png", "--right", left, "-o", out}, 3, "text.png");
    expect_failure({"run", "--left", left, "--right", folder / "small.pgm", "-o", out}, 3, "20x20");
    expect_failure({"run", "--disparity", map, "--color", folder / "small.pgm", "-o", out}, 3, "20x20");
    expect_failure({"run", "--disparity", folder / "small.pgm", "-o", out}, 3, "scale");
    expect_failure({"run", "--disparity", map, "--calib", folder / "calib.txt", "-o", out}, 3, "33x44");
    expect_failure({"run", "--disparity", map, "--calib", folder / "none.txt", "-o", out}, 3, "none.txt");
    expect_failure({"run", "--disparity", map, "--set", "density.background.method=threshold_px", "--set",
                    "density.background.threshold_px=60000", "--quiet", "-o", out},
                   3, "background");
    expect_failure({"info", folder / "none.glb"}, 3, "none.glb");
    expect_failure({"info", folder / "text.png"}, 3, "text.png");
    expect_failure({"info", folder.path().string()}, 3, "folder");
    expect_failure({"info", sample("left.png"), "--max-pixels", "76799"}, 3,
                   "left.png': its size is 320x240, more than the limit of 76799 pixels (--max-pixels)");
    expect_failure({"info", sample("left.png"), "--max-pixels", "0"}, 2, "--max-pixels");
    expect_failure({"evaluate", folder / "none.pfm", map}, 3, "none.pfm");
    write_text(folder / "grey.pgm", "P5\n64 48\n255\n" + std::string(64 * 48, 'x'));
    expect_failure({"evaluate", folder / "grey.pgm", map}, 3, "give --scale.");
    expect_failure({"evaluate", map, folder / "grey.pgm"}, 3, "give --gt-scale.");
    const std::string blank = folder / "grey.pgm";
    expect_failure({"run", "--left", blank, "--right", blank, "-o", out, "--set",
                    "input.calibration.focal_px=64", "--set", "input.calibration.baseline_m=1"},
                   3, "nothing matched: the left picture is blank");
    EXPECT_FALSE(std::filesystem::exists(out));
}

TEST(CommandLine, OutputErrorsExitWith4BeforeTheWork) {
    const TemporaryFolder folder;
    write_text(folder / "file", "");
    std::filesystem::create_directory(folder / "folder.glb");
    expect_failure(pair_arguments({"-o", folder / "file/below/o.glb"}), 4, "file");
    expect_failure(pair_arguments({"-o", folder / "file/o.glb"}), 4, "file");
    expect_failure(pair_arguments({"-o", folder / "folder.glb"}), 4, "folder.glb");
    expect_failure(pair_arguments({"-o", folder / "o.glb", "--report", folder / "file/r.json"}), 4, "file");
    expect_failure(pair_arguments({"-o", folder / "o.glb", "--save-stages", folder / "file"}), 4, "file");
    expect_failure(pair_arguments({"-o", folder / "o.glb", "--save-stages", folder / "file/below"}), 4,
                   "file");
    expect_failure(
        {"run", "--left", folder / "none.png", "--right", folder / "none.png", "-o", folder / "file/o.glb"},
        4, "file");
    EXPECT_EQ(folder.entries(), 2);
}

#ifndef HEXRELIEF_HAS_CUDA
TEST(CommandLine, DeviceErrorsExitWith5) {
    const TemporaryFolder folder;
    expect_failure(pair_arguments({"-o", folder / "o.glb", "--backend", "cuda"}), 5, "built without CUDA");
}
#endif

TEST(CommandLine, FullStandardOutputIsAnOutputError) {
    if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
    EXPECT_EQ(run_program_into("/dev/full", {"config", "show"}), 4);
    EXPECT_EQ(run_program_into("/dev/full", {"devices"}), 4);
    EXPECT_EQ(run_program_into("/dev/full", {"--help"}), 4);
    EXPECT_EQ(run_program_into("/dev/full", {"--version"}), 4);
}

// Names and values may come from anywhere: they must not steer the terminal, nor fill it.
TEST(CommandLine, MessagesCannotSteerTheTerminal) {
    const TemporaryFolder folder;
    const std::string evil = "\x1b[2J\x1b]0;title\a\x9b" + std::string(1, '\xff') + "\u202e";
    const std::string shown = "\\x1b[2J\\x1b]0;title\\x07\\x9b\\xff\\xe2\\x80\\xae";
    expect_failure({"info", folder / evil}, 3, shown);
    expect_failure({"run", "--left", evil, "--right", evil, "-o", folder / "a.glb"}, 3, shown);
    expect_failure({"config", "show", "--set", "mesh.seed=" + evil}, 2, shown);
    const ProcessResult result = expect_success(
        {"run", "--disparity", sample("disparity.pfm"), "-o", folder / (evil + ".drc"), "--verbose"});
    EXPECT_CONTAINS(result.out, shown);
    EXPECT_EQ((result.out + result.err).find('\x1b'), std::string::npos);
    expect_failure({"config", "show", "--set", "mesh.seed=" + std::string(100000, 'x')}, 2, " [...] ");
    EXPECT_LT(run_program({"config", "show", "--set", "mesh.seed=" + std::string(100000, 'x')}).err.size(),
              2100u);
}

TEST(CommandLine, PlainMistakesAreNoInternalErrors) {
    const TemporaryFolder folder;
    const std::string map = sample("disparity.pfm"), out = folder / "o.glb";
    const auto camera = [&](const std::string& more) {
        write_text(folder / "calib.txt",
                   "cam0=[320 0 159.5; 0 320 119.5; 0 0 1]\ncam1=[320 0 159.5; 0 320 119.5; 0 0 1]\n"
                   "width=320\nheight=240\n" +
                       more);
        return std::vector<std::string>{"run", "--disparity", map, "--calib", folder / "calib.txt", "-o",
                                        out};
    };
    expect_failure(camera("doffs=1e308\nbaseline=200\n"), 3, "(doffs) is 1e+308 px");
    expect_failure(camera("doffs=0\nbaseline=1e-308\n"), 3, "baseline is 1e-311 m");
    expect_failure(camera("doffs=0\nbaseline=1e308\n"), 3, "baseline is 1e+305 m");
    expect_failure({"config", "show", "--set", "input.calibration.file=\xff.txt"}, 2, "no UTF-8");
    expect_failure({"run", "--disparity", map, "-o", folder / "a\nb.obj"}, 2, "has a line break");
    write_text(folder / "far.pfm", "Pf\n2 1\n-1\n" + std::string("\xca\xf2\x49\x71\xca\xf2\x49\x71"));
    expect_failure({"run", "--disparity", folder / "far.pfm", "-o", out}, 3, "at most a million px");
    std::filesystem::create_symlink("/dev/null", folder / "null.glb");
    expect_success({"run", "--disparity", map, "-o", folder / "null.glb"});
    EXPECT_TRUE(std::filesystem::is_symlink(folder / "null.glb"));
}

TEST(CommandLine, ConfigShowRoundTrips) {
    const TemporaryFolder folder;
    const ProcessResult shown = expect_success({"config", "show", "--set", "mesh.seed=7"});
    write_text(folder / "a.yaml", shown.out);
    expect_success({"config", "check", folder / "a.yaml"});
    EXPECT_EQ(run_program({"config", "show", "--config", folder / "a.yaml"}).out, shown.out);
    EXPECT_CONTAINS(shown.out, "seed: 7\n");
    EXPECT_TRUE(nlohmann::json::accept(run_program({"config", "schema"}).out));
    EXPECT_CONTAINS(run_program({"config", "show", "--markdown"}).out, "- `mesh.seed` (");
}

TEST(CommandLine, EvaluateAgreesWithItself) {
    const ProcessResult result =
        expect_success({"evaluate", sample("disparity.pfm"), sample("disparity.pfm"), "--json"});
    const auto json = nlohmann::json::parse(result.out);
    EXPECT_EQ(json["bad_0.5_percent"], 0);
    const TemporaryFolder folder;
    const std::string not_utf8 = folder / "\xff.pfm";
    std::filesystem::copy_file(sample("disparity.pfm"), not_utf8);
    EXPECT_EQ(run_program({"evaluate", not_utf8, not_utf8, "--json"}).out, result.out);
    EXPECT_EQ(json["coverage_percent"], 100);
    EXPECT_CONTAINS(run_program({"evaluate", sample("disparity.pfm"), sample("disparity.pfm")}).out,
                    "bad-0.5");
    const ProcessResult shifted = run_program(
        {"evaluate", sample("disparity.pfm"), sample("disparity.pfm"), "--offset", "3", "--json"});
    EXPECT_EQ(nlohmann::json::parse(shifted.out)["bad_2_percent"], 100);
    EXPECT_EQ(nlohmann::json::parse(shifted.out)["bad_4_percent"], 0);
}

TEST(CommandLine, EvaluateTakesTheRightViewsTruthAndTheLeastDiscontinuity) {
    const std::string map = sample("disparity.pfm");
    const auto figures = [&](const std::vector<std::string>& more) {
        const ProcessResult result = expect_success({"evaluate", map, map, "--json"}, more);
        return nlohmann::json::parse(result.out);
    };
    const auto alone = figures({}), beside = figures({"--gt-right", map}),
               coarse = figures({"--discontinuity", "4"});
    EXPECT_EQ(alone["bad_1_nonoccluded_percent"], 0);
    EXPECT_LT(alone["nonoccluded_pixels"], alone["truth_pixels"]);
    EXPECT_LT(beside["nonoccluded_pixels"], alone["nonoccluded_pixels"])
        << "the left view is not the right one";
    EXPECT_LT(coarse["edge_pixels"], alone["edge_pixels"]);
    EXPECT_EQ(alone["edge_wrong_percent"], 0);
    EXPECT_EQ(alone["edge_unknown_percent"], 0);
    EXPECT_GT(alone["roughness_windows"], 100);
    EXPECT_LT(alone["roughness_px"], 0.3);
    EXPECT_CONTAINS(run_program({"evaluate", map, map}).out, "bad-2 nonocc.");
    expect_failure({"evaluate", map, map, "--discontinuity", "0"}, 2, "above 0");
}

TEST(CommandLine, InfoLimitsWhatDecodersTake) {
    // A TIFF of one strip of 23000 x 23000 px in four inks, which its decoder wants to hold at once.
    std::string file("II*\0\x08\0\0\0\x09\0", 10);
    const auto append = [&](std::uint32_t value, int bytes) {
        for (int i = 0; i < bytes; ++i) file += static_cast<char>(value >> 8 * i);
    };
    for (const auto& [tag, value] : std::vector<std::pair<std::uint32_t, std::uint32_t>>{{256, 23000},
                                                                                         {257, 23000},
                                                                                         {258, 8},
                                                                                         {259, 34925},
                                                                                         {262, 5},
                                                                                         {273, 122},
                                                                                         {277, 4},
                                                                                         {278, 23000},
                                                                                         {279, 20}})
        append(tag, 2), append(4, 2), append(1, 4), append(value, 4);
    file += std::string(24, '\0') + std::string(12 << 10, '\0');
    const TemporaryFolder folder;
    write_text(folder / "a.tif", file);
    // The header says four channels, so that the samples are decoded, to look for transparent ones.
    const std::string error = run_program({"info", folder / "a.tif"}).err;
    const auto says = [&](const char* text) { return error.find(text) != std::string::npos; };
#ifdef __SANITIZE_ADDRESS__
    // AddressSanitizer itself takes more memory than the limit, so that only time is limited.
    EXPECT_TRUE(says("malformed TIFF") || says("of processor time, which no whole file of its length does"))
        << error;
#else
    EXPECT_TRUE(says("wants more memory than files of its length need")) << error;
#endif
}

TEST(CommandLine, InfoTellsWhatAMapIsTakenFor) {
    const auto info = [](std::vector<std::string> arguments) {
        arguments[0] = sample("inputs/" + arguments[0]);
        arguments.insert(arguments.begin(), "info");
        const ProcessResult result = expect_success(arguments);
        return result.out;
    };
    const auto expect = [](const std::string& text, const std::string& part) { EXPECT_CONTAINS(text, part); };
    expect(info({"depth_mm.png"}), "as depth      16-bit integers, mm: 1.");
    expect(info({"depth_mm.png"}), "as disparity  16-bit integers, 1/256 px as KITTI's: ");
    expect(info({"depth.pfm"}), "as depth      floats, m: 1.");
    expect(info({"depth.tif"}), " % known");
    expect(info({"mask.png"}), "as mask       keeps");
    expect(info({"mask.png"}), "as depth      refused: an 8-bit depth map");
    expect(info({"cut_out.png"}), " % transparent");
    expect(info({"depth.npz"}), "holds         ");
    expect(info({"depth_mm.png"}), "              --depth-unit 5000: ");
    expect(info({"depth.npz", "--key", "depth"}), "as depth      floats, m: 1.");
    expect(info({"K.npy"}), "format        calibration, camera matrix\nfocal");
}

TEST(CommandLine, InfoAndDevicesTell) {
    EXPECT_CONTAINS(run_program({"info", sample("left.png")}).out, "png");
    EXPECT_CONTAINS(run_program({"info", sample("disparity.pfm")}).out, "known");
    EXPECT_CONTAINS(run_program({"info", sample("calib.txt")}).out, "baseline");
    EXPECT_TRUE(run_program({"devices"}).out.starts_with("cpu"));
    const auto json = [](std::vector<std::string> words) {
        words.emplace_back("--json");
        return nlohmann::json::parse(run_program(words).out);
    };
    EXPECT_EQ(json({"devices"})[0]["backend"], "cpu");
    EXPECT_EQ(json({"info", sample("left.png")})["size"], nlohmann::json({{"width", 320}, {"height", 240}}));
    EXPECT_GT(json({"info", sample("disparity.pfm")})["known"], 0.5);
    EXPECT_GT(json({"info", sample("disparity.pfm")})["as_disparity"].size(), 0u);
    EXPECT_GT(json({"info", sample("calib.txt")})["baseline"], 0);
}

}  // namespace
}  // namespace hexrelief::cli
