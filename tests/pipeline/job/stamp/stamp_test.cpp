// Tests when a unit is up to date.
#include "pipeline/job/stamp/stamp.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "pipeline/config/reader.h"
#include "pipeline/data/error.h"
#include "pipeline/job/runner.h"
#include "tests/pipeline/process.h"

namespace hexrelief::job {
namespace {

namespace fs = std::filesystem;
using test::TemporaryFolder;

RunRequest map_request(const TemporaryFolder& folder) {
    fs::copy_file(test::sample("disparity.pfm"), folder / "d.pfm");
    RunRequest request{.source = DisparityFiles{folder / "d.pfm"},
                       .outputs = {folder / "a.drc"},
                       .report = folder / "a.json"};
    config::apply_setting(request.config, "mesh.spacing_px=24");
    return request;
}

void run_stamped(RunRequest& request) {
    request.stamp = unit_stamp(request);
    run_job(request);
}

TEST(Stamp, DependsOnAllThatTheBytesDependOn) {
    const TemporaryFolder folder;
    const RunRequest request = map_request(folder);
    const std::string stamp = unit_stamp(request);
    EXPECT_EQ(stamp.size(), 64u);

    RunRequest other = request;
    other.config.run.threads = 7;
    other.config.run.backend = config::BackendChoice::cpu;
    other.outputs = {"elsewhere/a.drc"};
    EXPECT_EQ(unit_stamp(other), stamp) << "threads, backend and folders change no byte";
    other = request;
    config::apply_setting(other.config, "mesh.seed=2");
    EXPECT_NE(unit_stamp(other), stamp);
    other = request;
    other.outputs = {folder / "a.glb"};
    EXPECT_NE(unit_stamp(other), stamp);
    other = request;
    other.source = DisparityFiles{folder / "d.pfm", folder / "d.pfm"};
    EXPECT_NE(unit_stamp(other), stamp);
    test::write_text(folder / "d.pfm", "another");
    EXPECT_NE(unit_stamp(request), stamp);
    fs::remove(folder / "d.pfm");
    EXPECT_THROW(unit_stamp(request), Error);
}

TEST(Stamp, DependsOnTheFilesOfAMatchersCommand) {
    const TemporaryFolder folder;
    RunRequest request = map_request(folder);
    test::write_text(folder / "match.py", "first");
    request.config.disparity.command = "python3 " + (folder / "match.py") + " {out}";
    const std::string stamp = unit_stamp(request);
    EXPECT_EQ(unit_stamp(request), stamp);
    test::write_text(folder / "match.py", "second");
    EXPECT_NE(unit_stamp(request), stamp);
}

TEST(Stamp, RefusesAFileThatCannotBeReadAsTheRunDoes) {
    const TemporaryFolder folder;
    RunRequest request = map_request(folder);
    const std::string missing = folder / "none", told = "cannot read '" + missing + "': ";
    request.source = DisparityFiles{missing};
    EXPECT_EQ(test::error_of([&] { unit_stamp(request); }), told + "no such file; check the path");
    for (const fs::path& unreadable : {fs::path(missing), folder.path()}) {
        request.source = DisparityFiles{unreadable};
        EXPECT_EQ(test::error_of([&] { unit_stamp(request); }), test::error_of([&] { run_job(request); }));
    }
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
    run_job(request);
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

TEST(Stamp, EachOutputIsToBeWhereItIsAskedFor) {
    const TemporaryFolder folder;
    RunRequest request = map_request(folder);
    request.outputs = {folder / "one/a.obj", folder / "two/a.obj", folder / "two/a.gltf"};
    // The last two share the picture's texture.
    request.source = DisparityFiles{folder / "d.pfm", test::sample("left.png")};
    run_stamped(request);
    EXPECT_EQ(stamp_request(request), UnitState::current);
    RunRequest elsewhere = request;
    elsewhere.outputs = {folder / "three/a.obj", folder / "two/a.obj", folder / "two/a.gltf"};
    EXPECT_EQ(stamp_request(elsewhere), UnitState::changed) << "nothing is there yet";
    fs::copy_file(folder / "two/a.obj", folder / "a.obj");
    for (const std::string name : {"one/a.obj", "two/a.obj", "two/a.mtl", "two/a.bin", "two/a_texture.jpg"}) {
        fs::rename(folder / name, folder / "hidden");
        EXPECT_EQ(stamp_request(request), UnitState::changed) << name;
        fs::rename(folder / "hidden", folder / name);
    }
    EXPECT_EQ(stamp_request(request), UnitState::current);
}

TEST(Stamp, FoldersMayBeMovedAndCopied) {
    const TemporaryFolder folder;
    RunRequest request = map_request(folder);
    request.outputs = {folder / "old/a.gltf", folder / "old/part/a.gltf"};
    request.report = folder / "old/a.json";
    request.stages_folder = folder / "old/stages";
    run_stamped(request);
    fs::copy(folder / "old", folder / "new", fs::copy_options::recursive);
    RunRequest copied = request;
    copied.outputs = {folder / "new/a.gltf", folder / "new/part/a.gltf"};
    copied.report = folder / "new/a.json";
    copied.stages_folder = folder / "new/stages";
    EXPECT_EQ(stamp_request(copied), UnitState::current);
    fs::remove(folder / "new/part/a.bin");
    EXPECT_EQ(stamp_request(copied), UnitState::changed) << "the one that was copied from does not count";
    fs::remove_all(folder / "old");
    fs::rename(folder / "new", folder / "old");
    EXPECT_EQ(stamp_request(request), UnitState::changed);
    run_stamped(request);
    fs::rename(folder / "old", folder / "new");
    EXPECT_EQ(stamp_request(copied), UnitState::current);
}

TEST(Stamp, EveryFileOfTheStagesAndTheDepfileAreToBeThere) {
    const TemporaryFolder folder;
    RunRequest request = map_request(folder);
    request.stages_folder = folder / "stages";
    request.depfile = folder / "a.d";
    run_stamped(request);
    EXPECT_EQ(stamp_request(request), UnitState::current);
    for (const std::string name : {"stages/weights.png", "stages/mesh2d.obj", "a.d"}) {
        fs::rename(folder / name, folder / "hidden");
        EXPECT_EQ(stamp_request(request), UnitState::changed) << name;
        fs::rename(folder / "hidden", folder / name);
    }
    EXPECT_EQ(stamp_request(request), UnitState::current);
}

TEST(Stamp, APairThatNeedsNoRectifyingHasNoRectifiedFiles) {
    const TemporaryFolder folder;
    RunRequest request = map_request(folder);
    request.source = PairFiles{test::sample("left.png"), test::sample("right.png")};
    request.config.input.calibration.file = test::sample("calib.txt");
    request.stages_folder = folder / "stages";
    run_stamped(request);
    EXPECT_FALSE(fs::exists(folder / "stages/left_rectified.png"));
    EXPECT_EQ(stamp_request(request), UnitState::current);
    const std::string stamp = request.stamp;
    fs::copy_file(test::sample("calib.txt"), folder / "calib.txt");
    request.config.input.calibration.file = folder / "calib.txt";
    EXPECT_EQ(unit_stamp(request), stamp) << "the file's bytes count, not its name";
    test::write_text(folder / "calib.txt", test::read_text(folder / "calib.txt") + "\n");
    EXPECT_NE(unit_stamp(request), stamp);
}

TEST(Stamp, ReportsNestedTooDeeplyAreNone) {
    const TemporaryFolder folder;
    const RunRequest request = map_request(folder);
    test::write_text(request.report,
                     R"({"stamp":)" + std::string(100000, '[') + std::string(100000, ']') + "}");
    EXPECT_EQ(unit_state(request, unit_stamp(request)), UnitState::missing);
}

}  // namespace
}  // namespace hexrelief::job
