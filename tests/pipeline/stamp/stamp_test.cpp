// When a unit is up to date.
#include "pipeline/stamp/stamp.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "pipeline/config/reader.h"
#include "pipeline/data/error.h"
#include "pipeline/job/runner.h"
#include "tests/pipeline/process.h"

namespace hexrelief {
namespace {

namespace fs = std::filesystem;
using test::TemporaryFolder;

RunRequest map_request(const TemporaryFolder& folder) {
    fs::copy_file(test::sample("disparity.pfm"), folder / "d.pfm");
    RunRequest request;
    request.disparity = folder / "d.pfm";
    request.outputs = {folder / "a.drc"};
    request.report = folder / "a.json";
    apply_setting(request.config, "mesh.spacing_px=24");
    return request;
}

TEST(Stamp, DependsOnAllThatTheBytesDependOn) {
    const TemporaryFolder folder;
    const RunRequest request = map_request(folder);
    const std::string stamp = unit_stamp(request);
    EXPECT_EQ(stamp.size(), 64u);

    RunRequest other = request;
    other.config.run.threads = 7;
    other.config.run.backend = BackendChoice::cpu;
    other.outputs = {"elsewhere/a.drc"};
    EXPECT_EQ(unit_stamp(other), stamp) << "threads, backend and folders change no byte";
    other = request;
    apply_setting(other.config, "mesh.seed=2");
    EXPECT_NE(unit_stamp(other), stamp);
    other = request;
    other.outputs = {folder / "a.glb"};
    EXPECT_NE(unit_stamp(other), stamp);
    other = request;
    other.color = request.disparity;
    EXPECT_NE(unit_stamp(other), stamp);
    test::write_text(folder / "d.pfm", "another");
    EXPECT_NE(unit_stamp(request), stamp);
    fs::remove(folder / "d.pfm");
    EXPECT_THROW(unit_stamp(request), Error);
}

TEST(Stamp, DoesNotDependOnLimits) {
    RunRequest request;
    const std::string stamp = unit_stamp(request);
    request.config.limits.max_memory = 1000;
    request.config.limits.reading.max_pixels = 1000;
    request.config.given.insert("limits.max_memory");
    EXPECT_EQ(unit_stamp(request), stamp);
}

TEST(Stamp, IsHeldAgainstTheReportAndTheOutputsBytes) {
    const TemporaryFolder folder;
    RunRequest request = map_request(folder);
    EXPECT_EQ(stamp_request(request), UnitState::missing);
    run_job(request, {});
    EXPECT_EQ(stamp_request(request), UnitState::current);
    EXPECT_EQ(unit_state(request, "another stamp"), UnitState::changed);

    const std::string output = test::read_text(folder / "a.drc");
    std::string touched = output;
    touched.back() = static_cast<char>(touched.back() ^ 1);
    test::write_text(folder / "a.drc", touched);
    EXPECT_EQ(stamp_request(request), UnitState::changed) << "one bit of an output";
    fs::remove(folder / "a.drc");
    EXPECT_EQ(stamp_request(request), UnitState::changed);
    test::write_text(folder / "a.drc", output);
    EXPECT_EQ(stamp_request(request), UnitState::current);
    for (const std::string& broken :
         std::vector<std::string>{"{\"stamp\": 1}", "", "[]", "{\"stamp\": \"" + request.stamp + "\"}"}) {
        test::write_text(folder / "a.json", broken);
        EXPECT_NE(stamp_request(request), UnitState::current) << broken;
    }
}

}  // namespace
}  // namespace hexrelief
