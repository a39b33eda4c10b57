// `hexrelief batch` through the built program.
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>

#include "pipeline/files/sha256.h"
#include "tests/pipeline/process.h"

namespace hexrelief::cli {
namespace {

using namespace test;

std::string job(const std::string& output, const std::string& more = "") {
    return "--disparity " + sample("disparity.pfm") + " --calib " + sample("calib.txt") + " -o \"" + output +
           "\" " + more + "\n";
}

TEST(Batch, WritesWhatSingleRunsWrite) {
    const TemporaryFolder folder;
    write_text(folder / "jobs.txt",
               "# two jobs\n\n" + job(folder / "a b.drc") + job(folder / "c.drc", "--set mesh.spacing_px=9"));
    const ProcessResult batch = expect_success({"batch", folder / "jobs.txt"});
    EXPECT_EQ(std::count(batch.out.begin(), batch.out.end(), '\n'), 4) << batch.out;
    EXPECT_CONTAINS(batch.out, R"("event":"end","units":2,"done":2)");
    const ProcessResult single = expect_success({"run", "--disparity", sample("disparity.pfm"), "--calib",
                                                 sample("calib.txt"), "-o", folder / "single.drc"});
    EXPECT_EQ(files::sha256_of_file(folder / "a b.drc"), files::sha256_of_file(folder / "single.drc"));
    EXPECT_NE(files::sha256_of_file(folder / "c.drc"), files::sha256_of_file(folder / "single.drc"));
}

TEST(Batch, ChecksAllLinesBeforeTheFirstJob) {
    const TemporaryFolder folder;
    write_text(folder / "jobs.txt", job(folder / "a.drc") + job(folder / "b.drc", "--no-such-option 1"));
    const ProcessResult batch = run_program({"batch", folder / "jobs.txt"});
    EXPECT_EQ(batch.exit_code, 2);
    EXPECT_CONTAINS(batch.err, "jobs.txt:2: ");
    EXPECT_EQ(folder.entries(), 1);
}

TEST(Batch, AJobThatFailsStopsNoOther) {
    const TemporaryFolder folder;
    write_text(folder / "bad.pfm", "no map");
    write_text(folder / "jobs.txt", job(folder / "a.drc") + "--disparity " + (folder / "bad.pfm") + " -o " +
                                        (folder / "b.drc") + "\n" + job(folder / "c.drc"));
    const ProcessResult batch = run_program({"batch", folder / "jobs.txt", "--log", "text"});
    EXPECT_EQ(batch.exit_code, 3);
    EXPECT_CONTAINS(batch.err, "jobs.txt:2: ");
    EXPECT_CONTAINS(batch.out, "2 done, 0 up to date, 1 failed");
    EXPECT_TRUE(std::filesystem::exists(folder / "a.drc"));
    EXPECT_TRUE(std::filesystem::exists(folder / "c.drc"));
}

TEST(Batch, AManifestIsDoneOnceWithItsTable) {
    const TemporaryFolder folder;
    write_text(folder / "m.csv", "disparity,name,mesh.spacing_px\n" + sample("disparity.pfm") + ",a,24\n" +
                                     sample("disparity.pfm") + ",b,\n");
    const std::vector<std::string> batch = {"batch", folder / "m.csv", "-o",    folder / "out", "--format",
                                            "drc",   "--depfile",      "--log", "text"};
    const auto with = [&](const std::string& more) { return run_program(batch, {more}); };
    EXPECT_CONTAINS(with("--dry-run").out, "b: to do, no result yet");
    EXPECT_FALSE(std::filesystem::exists(folder / "out"));
    const ProcessResult commands = with("--print-commands");
    EXPECT_EQ(std::count(commands.out.begin(), commands.out.end(), '\n'), 2) << commands.out;
    EXPECT_TRUE(commands.out.starts_with("hexrelief run --update --disparity ")) << commands.out;

    const ProcessResult first = expect_success(batch);
    EXPECT_CONTAINS(first.out, "2 done, 0 up to date");
    EXPECT_TRUE(
        read_text(folder / "out/batch.csv").starts_with("name,status,exit_code,error,warnings,schema"));
    EXPECT_EQ(read_text(folder / "out/a.d"), (folder / "out/a.drc") + ": \\\n  " + sample("disparity.pfm") +
                                                 "\n\n" + sample("disparity.pfm") + ":\n");
    EXPECT_CONTAINS(run_program(batch).out, "0 done, 2 up to date");
    EXPECT_CONTAINS(with("--force").out, "2 done");
    EXPECT_CONTAINS(with("--shard=2/2").out, "1 row in");
    EXPECT_TRUE(std::filesystem::exists(folder / "out/batch-2-of-2.csv"));
    EXPECT_CONTAINS(with("--set=mesh.seed=2").out, "2 done");
}

TEST(Batch, TellsEachWarningOnceWithItsRows) {
    const TemporaryFolder folder;
    const std::string map = sample("disparity.pfm");  // without a calibration
    write_text(folder / "m.csv", "disparity,name\n" + map + ",a\n" + map + ",b\n");
    const std::vector<std::string> batch = {"batch", folder / "m.csv", "-o", folder / "out"};
    const ProcessResult told = expect_success(batch);
    EXPECT_TRUE(told.err.starts_with("hexrelief: warning: " + (folder / "m.csv") + ":2 (and 1 more rows): "))
        << told.err;
    EXPECT_EQ(std::count(told.err.begin(), told.err.end(), '\n'), 1) << told.err;
    EXPECT_CONTAINS(told.out, "\"warnings\":[\"");
    EXPECT_EQ(run_program(batch).err, "");  // nothing was done, so nothing is told
}

TEST(Batch, RowsThatAreWrongEndItUnlessItKeepsGoing) {
    const TemporaryFolder folder;
    write_text(folder / "m.csv", "disparity,name,mesh.spacing_px\n" + sample("disparity.pfm") + ",a,zero\n" +
                                     sample("disparity.pfm") + ",b,24\n");
    const ProcessResult refused = run_program({"batch", folder / "m.csv", "-o", folder / "out"});
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_CONTAINS(refused.err, "m.csv:2: ");
    EXPECT_FALSE(std::filesystem::exists(folder / "out"));
    const ProcessResult going =
        run_program({"batch", folder / "m.csv", "-o", folder / "out", "--keep-going"});
    EXPECT_EQ(going.exit_code, 2);
    EXPECT_TRUE(std::filesystem::exists(folder / "out/b.glb"));
}

TEST(Batch, NamesThatMakeWouldRunAreRefusedWithDepfiles) {
    const TemporaryFolder folder;
    std::filesystem::copy(sample("disparity.pfm"), folder / ";id>pwned;x=.pfm");
    write_text(folder / "m.csv", "disparity,name\n\";id>pwned;x=.pfm\",a\n");
    const ProcessResult refused = run_program({"batch", folder / "m.csv", "-o", folder / "out", "--depfile"});
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_CONTAINS(refused.err, "m.csv:2: --depfile: make cannot read the name");
    EXPECT_EQ(std::count(refused.err.begin(), refused.err.end(), '\n'), 1) << refused.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

TEST(Batch, AnInterruptEndsItAndTheNextCallDoesTheRest) {
    const TemporaryFolder folder;
    std::string rows = "disparity,name\n";
    for (int i = 0; i < 12; ++i) rows += sample("disparity.pfm") + ",n" + std::to_string(i) + "\n";
    write_text(folder / "m.csv", rows);
    const std::vector<std::string> batch = {"batch", folder / "m.csv",    "-o", folder / "out", "--jobs", "2",
                                            "--set", "mesh.spacing_px=24"};
    const pid_t process = start_program(batch);
    while (!std::filesystem::exists(folder / "out/n0.json")) usleep(1000);
    kill(process, SIGTERM);
    EXPECT_EQ(wait_for_exit(process), 130);
    EXPECT_FALSE(std::filesystem::exists(folder / "out/batch.csv"));
    for (const auto& entry : std::filesystem::directory_iterator(folder / "out")) {
        const std::string stem = entry.path().stem().string();
        EXPECT_TRUE(stem.starts_with("n")) << entry.path();
        EXPECT_TRUE(std::filesystem::exists(folder / ("out/" + stem + ".json"))) << entry.path();
    }
    const ProcessResult again = expect_success(batch);
    EXPECT_CONTAINS(again.out, R"("status":"up_to_date")");
    EXPECT_EQ(read_text(folder / "out/n11.glb"), read_text(folder / "out/n0.glb"));
}

TEST(Batch, ADryRunSaysByWhichRulePairsAreFound) {
    const TemporaryFolder folder;
    std::filesystem::create_directory(folder / "scene");
    std::filesystem::copy_file(sample("left.png"), folder / "scene/im0.png");
    std::filesystem::copy_file(sample("right.png"), folder / "scene/im1.png");
    const auto dry_run = [&](const std::string& log) {
        return run_program({"batch", folder.path(), "-o", folder / "out", "--dry-run", "--log", log}).out;
    };
    EXPECT_TRUE(dry_run("text").starts_with(
        "scene: to do, no result yet; found as Middlebury 2014 (im0.* and im1.*)\n"))
        << dry_run("text");
    EXPECT_CONTAINS(dry_run("jsonl"), R"x("rule":"Middlebury 2014 (im0.* and im1.*)")x");
}

TEST(Batch, OptionsThatAreNoneAreRefused) {
    const TemporaryFolder folder;
    write_text(folder / "jobs.txt", job(folder / "a.drc"));
    for (const std::string option :
         {"--shard=0/2", "--shard=3/2", "--shard=1", "--memory=much", "--memory=-1G", "--memory=99999999T",
          "--log=loud", "--jobs=-1", "--gpus=none"})
        EXPECT_NE(run_program({"batch", folder / "jobs.txt", option}).exit_code, 0) << option;
    EXPECT_EQ(folder.entries(), 1);
}

TEST(Run, UpdatesOnlyWhatChanged) {
    const TemporaryFolder folder;
    const std::vector<std::string> run = {
        "run",   "--update",           "--disparity", sample("disparity.pfm"),
        "--set", "mesh.spacing_px=24", "-o",          folder / "a.drc"};
    EXPECT_EQ(run_program(run).exit_code, 2) << "it needs a report";
    const std::vector<std::string> reported = joined(run, {"--report", folder / "a.json"});
    expect_success(reported);
    const ProcessResult second = expect_success(reported);
    EXPECT_CONTAINS(second.out, "a.json: up to date");
}

TEST(Batch, NeedsAFileWithJobs) {
    const TemporaryFolder folder;
    EXPECT_EQ(run_program({"batch"}).exit_code, 2);
    EXPECT_EQ(run_program({"batch", folder / "none.txt"}).exit_code, 3);
    write_text(folder / "empty.txt", "# nothing\n");
    EXPECT_EQ(run_program({"batch", folder / "empty.txt"}).exit_code, 3);
}

}  // namespace
}  // namespace hexrelief::cli
