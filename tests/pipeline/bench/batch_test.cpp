// Tests `hexrelief bench batch` on the sample pair, laid out like the data sets.
#include "pipeline/bench/batch/bench_batch.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "pipeline/bench/batch/files.h"
#include "pipeline/data/error.h"
#include "tests/pipeline/process.h"

namespace hexrelief::bench {
namespace {

namespace fs = std::filesystem;

BatchOptions sample_options(const test::TemporaryFolder& folder) {
    const fs::path scene = folder / "sample-quarter";
    fs::create_directories(scene);
    for (const std::string name : {"left.png", "right.png"}) fs::copy_file(test::sample(name), scene / name);
    fs::copy_file(test::sample("disparity.pfm"), scene / "disp.pfm");
    BatchOptions options;
    options.data = scene.parent_path();
    options.settings = {"mesh.spacing_px=12", "disparity.num_disparities_px=48"};
    options.jobs = 5;
    options.threads = 3;
    options.workers = 2;
    options.json = folder / "batch.json";
    return options;
}

TEST(BenchBatch, CountsTheTimedJobsOfAllWorkers) {
    const test::TemporaryFolder folder;
    const BatchOptions options = sample_options(folder);
    std::ostringstream out;
    run_bench_batch(options, out);
    EXPECT_NE(out.str().find("sample-quarter"), std::string::npos);
    std::ifstream file(options.json);
    const auto json = nlohmann::json::parse(file);
    EXPECT_EQ(json["threads"], 3);
    ASSERT_GE(json["rows"].size(), 1u);
    const auto& row = json["rows"][0];
    EXPECT_EQ(row["backend"], "cpu");
    EXPECT_EQ(row["workers"], 2);
    EXPECT_EQ(row["threads_each"], 1);
    EXPECT_EQ(row["jobs"], 5);
    EXPECT_GT(row["jobs_per_second"], 0);
    EXPECT_GT(row["bytes"], 0);
}

TEST(BenchBatch, GoesFromFilesToFiles) {
    const test::TemporaryFolder folder;
    BatchOptions options = sample_options(folder);
    options.jobs = 2;
    std::ostringstream out;
    run_bench_batch_files(options, out);
    std::ifstream file(options.json);
    const auto json = nlohmann::json::parse(file);
    ASSERT_EQ(json["rows"].size(), 1u);
    EXPECT_EQ(json["rows"][0]["scene"], "sample-quarter");
    EXPECT_GT(json["rows"][0]["one"]["jobs_per_second"], 0);
    EXPECT_GT(json["rows"][0]["all"]["cpu_seconds"], 0);
}

TEST(BenchBatch, RefusesWhatItCannotDo) {
    const test::TemporaryFolder folder;
    std::ostringstream out;
    const BatchOptions sound = sample_options(folder);
    BatchOptions options = sound;
    options.scenes = {"nowhere"};
    EXPECT_THROW(run_bench_batch(options, out), Error);
    options = sound;
    options.jobs = 0;
    EXPECT_THROW(run_bench_batch(options, out), Error);
}

}  // namespace
}  // namespace hexrelief::bench
