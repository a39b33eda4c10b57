// Tests batches of several processes, with RunRequests made by the test instead of from a command line.
#include "pipeline/batch/batch.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>

#include "pipeline/config/reader.h"
#include "tests/pipeline/process.h"

namespace hexrelief::batch {
namespace {

namespace fs = std::filesystem;
using test::TemporaryFolder;

// Makes a request from a unit's words: its output, the map, and what happens to its process.
job::RunRequest request_of_test(const std::vector<std::string>& words) {
    if (words.size() > 2 && words[2] == "die") ::kill(::getpid(), SIGKILL);
    if (words.size() > 2 && words[2] == "break") throw std::runtime_error("not even an Error");
    job::RunRequest request{.source = job::DisparityFiles{words[1]},
                            .outputs = {words[0] + ".drc"},
                            .report = words[0] + ".json"};
    config::apply_setting(request.config, "mesh.spacing_px=24");
    return request;
}

std::vector<BatchUnit> sample_units(const TemporaryFolder& folder, int count) {
    std::vector<BatchUnit> units;
    for (int i = 0; i < count; ++i) {
        const std::string name = "u" + std::to_string(i);
        units.push_back({"m:" + std::to_string(i), name, {folder / name, test::sample("disparity.pfm")}, ""});
    }
    return units;
}

std::vector<UnitOutcome> outcomes(const BatchResult& result) {
    std::vector<UnitOutcome> all;
    for (const UnitResult& unit : result.units) all.push_back(unit.outcome);
    return all;
}

BatchResult run_two_at_a_time(const std::vector<BatchUnit>& units, std::uint64_t memory = 0) {
    BatchSettings settings;
    settings.rules.parse = request_of_test;
    settings.workers = 2;
    settings.memory = memory;
    return run_units(units, settings, {});
}

TEST(RunUnits, DoesEachOnceAndThenNothing) {
    const TemporaryFolder folder;
    const std::vector<BatchUnit> units = sample_units(folder, 5);
    EXPECT_EQ(outcomes(run_two_at_a_time(units)), std::vector<UnitOutcome>(5, UnitOutcome::done));
    EXPECT_EQ(folder.entries(), 10);
    EXPECT_EQ(outcomes(run_two_at_a_time(units)), std::vector<UnitOutcome>(5, UnitOutcome::up_to_date));
    for (int i = 1; i < 5; ++i)
        EXPECT_EQ(test::read_text(folder / ("u" + std::to_string(i) + ".drc")),
                  test::read_text(folder / "u0.drc"));
}

TEST(RunUnits, NoUnitStopsTheOthers) {
    const TemporaryFolder folder;
    std::vector<BatchUnit> units = sample_units(folder, 5);
    units[0].words[1] = folder / "none.pfm";
    units[2].wrong = "it is wrong";
    units[3].words.emplace_back("break");
    const BatchResult result = run_two_at_a_time(units);
    EXPECT_EQ(outcomes(result),
              (std::vector<UnitOutcome>{UnitOutcome::failed, UnitOutcome::done, UnitOutcome::failed,
                                        UnitOutcome::failed, UnitOutcome::done}));
    EXPECT_EQ(result.units[0].exit_code, 3);
    EXPECT_EQ(result.units[2].message, "it is wrong");
    EXPECT_EQ(result.units[3].message, "internal error: not even an Error");
}

// A unit's words are read twice: first in this process, to estimate its memory, then in a worker.
TEST(RunUnits, AKilledWorkerIsReplaced) {
    const TemporaryFolder folder;
    std::vector<BatchUnit> units = sample_units(folder, 4);
    units[1].words.emplace_back("die");
    BatchSettings settings;
    settings.workers = 1;
    settings.rules.parse = [parent = ::getpid()](const std::vector<std::string>& words) {
        return request_of_test(::getpid() == parent ? std::vector(words.begin(), words.begin() + 2) : words);
    };
    const BatchResult result = run_units(units, settings, {});
    EXPECT_EQ(outcomes(result), (std::vector<UnitOutcome>{UnitOutcome::done, UnitOutcome::failed,
                                                          UnitOutcome::done, UnitOutcome::done}));
    EXPECT_CONTAINS(result.units[1].message, "Killed");
}

TEST(RunUnits, LittleMemoryMeansOneAtATime) {
    const TemporaryFolder folder;
    EXPECT_EQ(outcomes(run_two_at_a_time(sample_units(folder, 3), 1)),
              std::vector<UnitOutcome>(3, UnitOutcome::done));
}

TEST(CheckUnits, FilesThatRowsWouldShareAreFound) {
    const TemporaryFolder folder;
    std::vector<BatchUnit> units = sample_units(folder, 4);
    units[1].words[0] = units[0].words[0];
    units[2].words[1] = units[3].words[0] + ".drc";
    units[3].words[1] = units[0].words[1];
    check_units(units, request_of_test);
    EXPECT_EQ(units[0].wrong, "");
    EXPECT_CONTAINS(units[1].wrong, "is an output of m:0, too");
    EXPECT_EQ(units[2].wrong, "");
    EXPECT_CONTAINS(units[3].wrong, "an input of one row and an output of another, m:2");
}

}  // namespace
}  // namespace hexrelief::batch
