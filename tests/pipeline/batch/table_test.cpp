// Tests the table, the progress and the memory rule of a batch.
#include "pipeline/batch/table.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "pipeline/batch/worker.h"
#include "pipeline/job/run_files.h"
#include "tests/pipeline/process.h"

namespace hexrelief::batch {
namespace {

TEST(BatchTable, HasAColumnForEveryValueOfEveryReport) {
    const test::TemporaryFolder folder;
    test::write_text(folder / "a.json",
                     R"({"mesh":{"cost":1.5},"stages":[{"name":"mesh","seconds":2}],"warnings":["x","y"]})");
    test::write_text(folder / "b.json", R"({"mesh":{"cost":2,"more":[3,4]},"budget":null})");
    const std::vector<TableRow> rows = {
        {"a", "m:1", {UnitOutcome::done}, folder / "a.json"},
        {"b", "m:2", {UnitOutcome::up_to_date}, folder / "b.json"},
        {"c", "m:3", {UnitOutcome::failed, 0, 0, 3, "no, \"so\"", {"z"}}, {}}};
    EXPECT_EQ(table_csv(rows),
              "name,status,exit_code,error,warnings,mesh.cost,stages.mesh.seconds,mesh.more.0,mesh.more.1\n"
              "a,done,0,,x; y,1.5,2,,\n"
              "b,up_to_date,0,,,2,,3,4\n"
              "c,failed,3,\"no, \"\"so\"\"\",z,,,,\n");
    const auto json = nlohmann::json::parse(table_json(rows));
    ASSERT_EQ(json["rows"].size(), 3u);
    EXPECT_EQ(json["rows"][0]["report"]["mesh"]["cost"], 1.5);
    EXPECT_EQ(json["rows"][2]["error"], "no, \"so\"");
    EXPECT_TRUE(json["rows"][2]["report"].is_null());
    EXPECT_EQ(json["rows"][2]["warnings"], nlohmann::json({"z"}));
}

TEST(BatchProgress, TellsRateAndTimeLeft) {
    BatchCounts counts{.units = 200};
    for (int i = 0; i < 78; ++i) counts.add(UnitOutcome::done);
    for (int i = 0; i < 2; ++i) counts.add(UnitOutcome::failed);
    EXPECT_EQ(progress_bar(counts, 10), "[########............] 80/200, 2 failed, 8.0 a second, 0:15 left");
    EXPECT_EQ(batch_summary(counts, 10),
              "200 rows in 10.00 s, 8.0 a second: 78 done, 0 up to date, 2 failed\n");
    const auto event = nlohmann::json::parse(
        unit_event({"m:1", "a\xff", {}, {}}, {UnitOutcome::failed, 1, 2, 3, "why", {"w"}}, counts));
    EXPECT_EQ(event["status"], "failed");
    EXPECT_EQ(event["error"], "why");
    EXPECT_EQ(event["warnings"], nlohmann::json({"w"}));
    EXPECT_EQ(event["ended"], 80);
}

TEST(BatchMemory, OneUnitAlwaysFitsAndLargerOnesAreLearntOf) {
    MemoryRule rule(1000);
    EXPECT_TRUE(rule.fits(5000, 0));
    EXPECT_TRUE(rule.fits(400, 600));
    EXPECT_FALSE(rule.fits(401, 600));
    rule.learn(100, 50);
    EXPECT_EQ(rule.expected(100), 100u);
    rule.learn(100, 300);
    EXPECT_EQ(rule.expected(100), 300u);
    job::RunRequest request;
    request.source = job::PairFiles{test::sample("left.png"), test::sample("right.png")};  // 320 x 240
    EXPECT_EQ(job::estimated_memory(request), (40u << 20) + 320 * 240 * 150);
    EXPECT_GT(memory_to_use(), 1u << 20);
}

TEST(BatchTable, CellsAreNoFormulas) {
    const std::string text = table_csv({{"=1+1", "m:1", {UnitOutcome::failed, 0, 0, 3, "-4.5e-3"}, {}},
                                        {"@x", "m:2", {UnitOutcome::failed, 0, 0, 3, "+x"}, {}}});
    EXPECT_EQ(text, "name,status,exit_code,error,warnings\n'=1+1,failed,3,-4.5e-3,\n'@x,failed,3,'+x,\n");
}

}  // namespace
}  // namespace hexrelief::batch
