// Pairs matched by the programs in samples/matchers, and by networks.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>

#include "pipeline/readers/disparity_reader.h"
#include "tests/pipeline/process.h"

namespace hexrelief::cli {
namespace {

using namespace test;
namespace fs = std::filesystem;

bool python_has(const std::string& module) {
    return std::system(("/usr/bin/python3 -c 'import " + module + "' 2>/dev/null").c_str()) == 0;
}

std::string program(const std::string& name) {
    return std::string("/usr/bin/python3 ") + HEXRELIEF_SOURCE_DIR + "/samples/matchers/" + name;
}

// Meshes the sample pair with these settings, and returns the report.
nlohmann::json mesh_by(const TemporaryFolder& folder, const std::vector<std::string>& settings,
                       const std::string& output) {
    std::vector<std::string> words{
        "-o", folder / output, "--report", folder / "r.json", "--save-stages", folder / "stages"};
    for (const std::string& setting : settings) words.insert(words.end(), {"--set", setting});
    const ProcessResult result = expect_success(pair_arguments(words));
    return result.exit_code == 0 ? nlohmann::json::parse(read_text(folder / "r.json")) : nlohmann::json();
}

// Returns the share of the true map's pixels at which the latest run's is more than 2 px off, in percent.
double bad2(const TemporaryFolder& folder) {
    const DisparityMap map = readers::read_disparity_map(fs::path(folder / "stages") / "disparity.pfm", {}),
                       truth = readers::read_disparity_map(sample("disparity.pfm"), {});
    int known = 0, bad = 0;
    for (std::size_t i = 0; i < truth.values.size(); ++i)
        if (DisparityMap::known(truth.values[i])) {
            ++known;
            bad += !(std::abs(map.values.at(i) - truth.values[i]) <= 2);
        }
    return 100.0 * bad / known;
}

class SampleMatchers : public testing::TestWithParam<std::string> {};

TEST_P(SampleMatchers, AreCalledInBothForms) {
    if (!python_has("cv2.stereo")) GTEST_SKIP() << "Debian's python3-opencv is not installed";
    const TemporaryFolder folder;
    const std::string command = "disparity.method=command", words = program(GetParam());
    const nlohmann::json report = mesh_by(
        folder, {command, "disparity.command=" + words + " {left} {right} {out} {ndisp}"}, "command.ply");
    EXPECT_GT(report.at("disparity").at("support").get<double>(), 0.6);
    EXPECT_LT(bad2(folder), 10);
    mesh_by(folder, {command, "disparity.worker=" + words}, "worker.ply");
    EXPECT_TRUE(read_text(folder / "worker.ply") == read_text(folder / "command.ply"));
}
INSTANTIATE_TEST_SUITE_P(All, SampleMatchers, testing::Values("sgbm.py", "quasi_dense.py"),
                         [](const auto& named) { return named.param.substr(0, named.param.find('.')); });

TEST(Matchers, AWorkerServesABatchAndThePairThatItDiesOfFailsAlone) {
    if (!python_has("cv2")) GTEST_SKIP() << "Debian's python3-opencv is not installed";
    const TemporaryFolder folder;
    const std::string pids = folder / "pids", worker = folder / "worker.py";
    write_text(worker,
               "import os, sys\nsys.path.insert(0, '" HEXRELIEF_SOURCE_DIR
               "/samples/matchers')\nimport matching, sgbm\ndef match(*views):\n    print(os.getpid(), "
               "file=open('" +
                   pids + "', 'a'))\n    if len(open('" + pids +
                   "').readlines()) == 3: sys.exit('no memory')\n    return sgbm.match(*views)\n"
                   "matching.serve(match, [])\n");
    write_text(folder / "m.csv", "left,right,name\n");
    for (const std::string name : {"a", "b", "c"})
        write_text(folder / "m.csv", read_text(folder / "m.csv") + sample("left.png") + "," +
                                         sample("right.png") + "," + name + "\n");
    const auto batch = [&](const std::string& more) {
        return run_program({"batch", folder / "m.csv", "-o", folder / "out", "--format", "drc", "--jobs", "1",
                            "--log", "text", "--set", "disparity.method=command", "--set",
                            "disparity.worker=/usr/bin/python3 " + worker, more});
    };
    const std::string commands = batch("--print-commands").out;
    EXPECT_EQ(std::count(commands.begin(), commands.end(), '\n'), 3) << commands;
    EXPECT_CONTAINS(commands, "disparity.worker=/usr/bin/python3 " + worker);

    const ProcessResult first = batch("--threads=2");
    EXPECT_EQ(first.exit_code, 3);
    EXPECT_CONTAINS(first.out, "2 done, 0 up to date, 1 failed");
    EXPECT_CONTAINS(first.err,
                    "m.csv:3: disparity.worker: '/usr/bin/python3' ended with exit code 1: 'no memory'");
    std::istringstream lines(read_text(pids));
    const std::vector<std::string> asked{std::istream_iterator<std::string>(lines), {}};
    ASSERT_EQ(asked.size(), 5u);  // two views of each pair, but one of the second
    EXPECT_TRUE(asked[0] == asked[1] && asked[1] == asked[2] && asked[2] != asked[3] && asked[3] == asked[4]);

    EXPECT_CONTAINS(batch("--threads=2").out, "1 done, 2 up to date");
    EXPECT_CONTAINS(batch("--threads=2").out, "0 done, 3 up to date");
    write_text(worker, read_text(worker) + "# another program\n");
    EXPECT_CONTAINS(batch("--threads=2").out, "3 done, 0 up to date");
}

TEST(Matchers, AdaptersOfNetworksAreWholePython) {
    for (const auto& entry : fs::directory_iterator(fs::path(HEXRELIEF_SOURCE_DIR) / "samples/matchers"))
        if (entry.path().extension() == ".py") {
            const std::string compiled =
                "/usr/bin/python3 -c 'import sys; compile(open(sys.argv[1]).read(), sys.argv[1], \"exec\")' ";
            EXPECT_EQ(std::system((compiled + entry.path().string()).c_str()), 0) << entry.path();
        }
}

// Small graphs that match pairs, by make_models.py.
class Networks : public testing::Test {
  protected:
    void SetUp() override {
        if (!fs::exists(fs::path(HEXRELIEF_PROGRAM).parent_path() / "hexrelief-onnx"))
            GTEST_SKIP() << "this build has neither OpenCV's dnn nor ONNX Runtime";
        if (!python_has("onnx")) GTEST_SKIP() << "Debian's python3-onnx is not installed";
        fs::create_directory(models());
        ASSERT_EQ(std::system(("/usr/bin/python3 " + std::string(HEXRELIEF_SOURCE_DIR) +
                               "/tests/pipeline/job/make_models.py " + models())
                                  .c_str()),
                  0);
    }
    std::string models() const { return folder_ / "models"; }
    std::vector<std::string> by(const std::string& name) const {
        return {"disparity.method=onnx", "disparity.model=" + models() + "/" + name + ".onnx"};
    }
    std::vector<std::string> arguments(const std::string& name) const {
        return pair_arguments({"-o", folder_ / "x.glb", "--set", by(name)[0], "--set", by(name)[1]});
    }

    const TemporaryFolder folder_;
};

TEST_F(Networks, MatchAPairInAnySizeSignAndTiles) {
    for (const std::string name : {"block", "fixed", "unit-tiles"}) {
        const nlohmann::json report = mesh_by(folder_, by(name), name + ".ply");
        EXPECT_GT(report.at("disparity").at("support").get<double>(), 0.7) << name;
        EXPECT_LT(bad2(folder_), 8) << name;
    }
    std::vector<std::string> threads = by("block");
    threads.push_back("run.threads=3");
    mesh_by(folder_, threads, "threads.ply");
    EXPECT_TRUE(read_text(folder_ / "threads.ply") == read_text(folder_ / "block.ply"));
}

TEST_F(Networks, WhatCannotBeRunIsALineAndNothingIsWritten) {
    expect_failure(arguments("own-operator"), 3, "cannot run the network's operator 'OwnOperator'");
    expect_failure(arguments("rubbish"), 3, "rubbish.onnx: it is no ONNX file");
    expect_failure(arguments("huge"), 3, "too large to be run");
    expect_failure(arguments("missing"), 3, "missing.onnx");
    expect_failure(joined(arguments("block"), {"--set", "disparity.model_kind=other"}), 2,
                   "disparity.model_kind must be one of levels");
    expect_failure(pair_arguments({"-o", folder_ / "x.glb", "--set", "disparity.method=onnx"}), 2,
                   "disparity.method=onnx needs disparity.model");
    EXPECT_FALSE(fs::exists(folder_ / "x.glb"));
}

TEST_F(Networks, DamagedGraphsNeverCrashOrHangTheRun) {
    const std::string whole = read_text(models() + "/small.onnx");
    unsigned random = 7;
    for (int i = 0; i < 6; ++i) {
        std::string bytes = whole;
        for (int k = 0; k < 4; ++k) {
            random = random * 1664525 + 1013904223;
            bytes[(random >> 8) % bytes.size()] = static_cast<char>(random >> 3);
        }
        write_text(models() + "/damaged.onnx", bytes);
        const ProcessResult result = run_program(arguments("damaged"), {"--set", "disparity.timeout_s=20"});
        EXPECT_TRUE(result.exit_code == 0 || result.exit_code == 2 || result.exit_code == 3)
            << i << ": " << result.exit_code << " " << result.err;
    }
}

TEST(Matchers, TheRightPictureAloneChecksASuppliedMap) {
    const TemporaryFolder folder;
    const std::vector<std::string> map{"run",
                                       "-o",
                                       folder / "x.ply",
                                       "--disparity",
                                       sample("disparity.pfm"),
                                       "--color",
                                       sample("left.png"),
                                       "--color-right"};
    const ProcessResult fits = expect_success(map, {sample("right.png"), "--verbose"}),
                        other = expect_success(map, {sample("left.png"), "--verbose"});
    EXPECT_CONTAINS(fits.err, "of the pixels have another colour in the right picture");
    EXPECT_CONTAINS(other.err, "so that is not looked at");
    expect_failure({"run", "-o", folder / "x.ply", "--disparity", sample("disparity.pfm"), "--color-right",
                    sample("right.png")},
                   2, "--color-right needs --color");
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
