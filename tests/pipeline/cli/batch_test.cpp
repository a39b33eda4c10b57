// `hexrelief batch` through the built program.
#include <gtest/gtest.h>

#include <algorithm>

#include "pipeline/files/sha256.h"
#include "tests/pipeline/process.h"

namespace hexrelief::test {
namespace {

std::string job(const std::string& output, const std::string& more = "") {
    return "--disparity " + sample("disparity.pfm") + " --calib " + sample("calib.txt") + " -o \"" + output +
           "\" " + more + "\n";
}

TEST(Batch, WritesWhatSingleRunsWrite) {
    const TemporaryFolder folder;
    write_text(folder / "jobs.txt",
               "# two jobs\n\n" + job(folder / "a b.drc") + job(folder / "c.drc", "--set mesh.spacing_px=9"));
    const ProcessResult batch = run_program({"batch", folder / "jobs.txt"});
    ASSERT_EQ(batch.exit_code, 0) << batch.err;
    EXPECT_EQ(std::count(batch.out.begin(), batch.out.end(), '\n'), 5) << batch.out;
    EXPECT_NE(batch.out.find("2 jobs, "), std::string::npos) << batch.out;
    const ProcessResult single = run_program({"run", "--disparity", sample("disparity.pfm"), "--calib",
                                              sample("calib.txt"), "-o", folder / "single.drc"});
    ASSERT_EQ(single.exit_code, 0) << single.err;
    EXPECT_EQ(sha256_of_file(folder / "a b.drc"), sha256_of_file(folder / "single.drc"));
    EXPECT_NE(sha256_of_file(folder / "c.drc"), sha256_of_file(folder / "single.drc"));
}

TEST(Batch, ChecksAllLinesBeforeTheFirstJob) {
    const TemporaryFolder folder;
    write_text(folder / "jobs.txt", job(folder / "a.drc") + job(folder / "b.drc", "--no-such-option 1"));
    const ProcessResult batch = run_program({"batch", folder / "jobs.txt"});
    EXPECT_EQ(batch.exit_code, 2);
    EXPECT_NE(batch.err.find("jobs.txt:2: "), std::string::npos) << batch.err;
    EXPECT_EQ(folder.entries(), 1u);
}

TEST(Batch, EndsAtTheFirstJobThatFails) {
    const TemporaryFolder folder;
    write_text(folder / "bad.pfm", "no map");
    write_text(folder / "jobs.txt", job(folder / "a.drc") + "--disparity " + (folder / "bad.pfm") + " -o " +
                                        (folder / "b.drc") + "\n" + job(folder / "c.drc"));
    const ProcessResult batch = run_program({"batch", folder / "jobs.txt"});
    EXPECT_EQ(batch.exit_code, 3);
    EXPECT_NE(batch.err.find("jobs.txt:2: "), std::string::npos) << batch.err;
    EXPECT_TRUE(std::filesystem::exists(folder / "a.drc"));
    EXPECT_FALSE(std::filesystem::exists(folder / "c.drc"));
}

TEST(Batch, NeedsAFileWithJobs) {
    const TemporaryFolder folder;
    EXPECT_EQ(run_program({"batch"}).exit_code, 2);
    EXPECT_EQ(run_program({"batch", folder / "none.txt"}).exit_code, 3);
    write_text(folder / "empty.txt", "# nothing\n");
    EXPECT_EQ(run_program({"batch", folder / "empty.txt"}).exit_code, 3);
}

}  // namespace
}  // namespace hexrelief::test
