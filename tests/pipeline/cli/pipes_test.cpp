// The built program: inputs from pipes, and several configurations.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "tests/pipeline/process.h"

namespace hexrelief::cli {
namespace {

using namespace test;

// Returns the exit code of a shell's line.
int run_line(const std::string& line) {
    const int status = std::system(line.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(Pipes, GiveTheBytesThatFilesGive) {
    const TemporaryFolder folder;
    const std::string program = HEXRELIEF_PROGRAM, map = sample("disparity.pfm"), color = sample("left.png");
    expect_success({"run", "--disparity", map, "--color", color, "-o", folder / "file.drc"});
    EXPECT_EQ(run_line("cat " + map + " | " + program + " run --quiet --disparity - --color " + color +
                       " -o " + (folder / "minus.drc")),
              0);
    EXPECT_EQ(run_line("cat " + color + " | " + program + " run --quiet --disparity " + map +
                       " --color /dev/fd/0 -o " + (folder / "pipe.drc")),
              0);
    const std::string wanted = read_text(folder / "file.drc");
    EXPECT_FALSE(wanted.empty());
    EXPECT_EQ(read_text(folder / "minus.drc"), wanted);
    EXPECT_EQ(read_text(folder / "pipe.drc"), wanted);
}

TEST(Pipes, AreNamedAsTheyWereGiven) {
    const TemporaryFolder folder;
    const std::string program = HEXRELIEF_PROGRAM, err = folder / "err";
    EXPECT_EQ(
        run_line("echo no map | " + program + " run --disparity - -o " + (folder / "a.glb") + " 2>" + err),
        3);
    const std::string told = read_text(err);
    EXPECT_CONTAINS(told, "cannot read '-': ");
    EXPECT_EQ(told.find("/proc/"), std::string::npos) << told;
    EXPECT_EQ(std::count(told.begin(), told.end(), '\n'), 1) << told;
    EXPECT_EQ(run_line("echo no map | " + program + " run --left - --right - -o " + (folder / "a.glb") +
                       " 2>" + err),
              2);
    EXPECT_CONTAINS(read_text(err), "twice");
    EXPECT_EQ(run_line("cat " + sample("left.png") + " | " + program + " info --json - >" + (folder / "out")),
              0);
    EXPECT_EQ(nlohmann::json::parse(read_text(folder / "out"))["size"]["width"], 320);
}

TEST(Configurations, LaterOnesWin) {
    const TemporaryFolder folder;
    write_text(folder / "scene.yaml", "mesh:\n  spacing_px: 9\n");
    const auto shown = [&](std::vector<std::string> words) {
        words.insert(words.begin(), {"config", "show"});
        return run_program(words).out;
    };
    const std::string both = shown({"--config", "compact", "--config", folder / "scene.yaml"});
    EXPECT_CONTAINS(both, "spacing_px: 9\n");
    EXPECT_CONTAINS(both, "compression: draco");
    EXPECT_EQ(shown({"--config", folder / "scene.yaml", "--config", "compact"}),
              shown({"--config", "compact"}));
    write_text(folder / "jobs.csv", "disparity,name\n" + sample("disparity.pfm") + ",a\n");
    const std::string printed =
        run_program({"batch", folder / "jobs.csv", "-o", folder / "out", "--config", "compact", "--config",
                     folder / "scene.yaml", "--print-commands"})
            .out;
    EXPECT_LT(printed.find("--config compact"), printed.find("scene.yaml")) << printed;
}

TEST(Configurations, AllMistakesAreTold) {
    const TemporaryFolder folder;
    write_text(folder / "bad.yaml",
               "mesh:\n  spacing_px: 0\n  spacings: 1\nexport:\n  texture: tiff\n  material: lit\nrun: 3\n");
    const ProcessResult told = run_program({"config", "check", folder / "bad.yaml"});
    EXPECT_EQ(told.exit_code, 2);
    std::size_t at = 0;
    for (const char* const part : {"bad.yaml:2: mesh.spacing_px", "bad.yaml:3: unknown key 'mesh.spacings'",
                                   "bad.yaml:5: export.texture", "bad.yaml:7: run must be a section"}) {
        at = told.err.find(part, at);
        ASSERT_NE(at, std::string::npos) << part << " in " << told.err;
    }
    EXPECT_EQ(std::count(told.err.begin(), told.err.end(), '\n'), 4) << told.err;
}

}  // namespace
}  // namespace hexrelief::cli
