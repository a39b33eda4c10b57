// Pairs matched by the program in samples/matchers.
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "tests/pipeline/process.h"

namespace hexrelief::cli {
namespace {

using namespace test;

TEST(Matchers, TheSamplesProgramIsCalledInBothForms) {
    if (std::system("/usr/bin/python3 -c 'import cv2' 2>/dev/null") != 0)
        GTEST_SKIP() << "Debian's python3-opencv is not installed";
    const TemporaryFolder folder;
    const std::string words =
        std::string("/usr/bin/python3 ") + HEXRELIEF_SOURCE_DIR + "/samples/matchers/sgbm.py";
    const auto mesh_by = [&](const std::string& setting, const std::string& name) {
        const ProcessResult result =
            run_program(pair_arguments({"-o", folder / name, "--report", folder / "r.json", "--set",
                                        "disparity.method=command", "--set", setting}));
        EXPECT_EQ(result.exit_code, 0) << result.err;
        return read_text(folder / name);
    };
    const std::string by_command =
        mesh_by("disparity.command=" + words + " {left} {right} {out} {ndisp}", "command.ply");
    const nlohmann::json report = nlohmann::json::parse(read_text(folder / "r.json"));
    EXPECT_GT(report.at("disparity").at("support").get<double>(), 0.8);
    EXPECT_EQ(mesh_by("disparity.worker=" + words, "worker.ply"), by_command);
    EXPECT_EQ(folder.entries(), 3u);
}

TEST(Matchers, AWrongCommandIsRefusedBeforeTheWork) {
    expect_failure(pair_arguments({"-o", "x.glb", "--set", "disparity.method=command"}), 2,
                   "disparity.command");
    expect_failure(pair_arguments({"-o", "x.glb", "--set", "disparity.method=command", "--set",
                                   "disparity.command=match {left} {right}"}),
                   2, "{out}");
}

}  // namespace
}  // namespace hexrelief::cli
