// All files that a run reads and writes are told apart before it starts.
#include <gtest/gtest.h>

#include "pipeline/data/error.h"
#include "pipeline/job/request.h"
#include "pipeline/job/run_files.h"
#include "tests/pipeline/process.h"

namespace hexrelief::job {
namespace {

namespace fs = std::filesystem;

// What check_request() says; empty where it lets the run begin.
std::string refusal_of(const RunRequest& request) {
    try {
        check_request(request);
    } catch (const Error& e) {
        return e.what();
    }
    return {};
}

class RunFiles : public testing::Test {
  protected:
    RunFiles() { request_.source = DisparityFiles{test::sample("disparity.pfm")}; }

    void expect_one_file(const std::string& one, const std::string& other) const {
        const std::string refusal = refusal_of(request_);
        EXPECT_CONTAINS(refusal, "would be one file");
        EXPECT_CONTAINS(refusal, one);
        EXPECT_CONTAINS(refusal, other);
    }

    test::TemporaryFolder folder_;
    RunRequest request_;
};

TEST_F(RunFiles, ReportsAreNoCompanions) {
    request_.outputs = {folder_ / "r.obj"};
    request_.report = folder_ / "r.mtl";
    expect_one_file("goes with the output", "the report");
    request_.outputs = {folder_ / "r.gltf"};
    request_.report = folder_ / "r.bin";
    expect_one_file("goes with the output", "the report");
}

TEST_F(RunFiles, EstimatesOfMoreMemoryThanTheLimitAreRefused) {
    request_.outputs = {folder_ / "r.glb"};
    request_.config.limits.max_memory = static_cast<long long>(estimated_memory(request_));
    EXPECT_EQ(refusal_of(request_), "");
    --request_.config.limits.max_memory;
    const std::string refusal = refusal_of(request_);
    EXPECT_CONTAINS(refusal, "disparity.pfm: its 320x240 px are estimated to take 53463040 bytes");
    EXPECT_CONTAINS(refusal, "53463039 (limits.max_memory)");
}

// Only the headers are read: the files hold no sample.
TEST_F(RunFiles, LargePairsAreEstimatedAtTheirWorkingSize) {
    const std::uint64_t base = 40 << 20, per_meshed_pixel = 150, per_pixel = 12;
    test::write_text(folder_ / "view.pgm", "P5\n4000 3000\n255\n");
    test::write_text(folder_ / "both.pgm", "P5\n8000 3000\n255\n");
    request_.source = PairFiles{folder_ / "view.pgm", folder_ / "view.pgm"};
    EXPECT_EQ(estimated_memory(request_), base + 2000 * 1500 * per_meshed_pixel + 4000 * 3000 * per_pixel);
    request_.source = StereoFile{folder_ / "both.pgm"};
    EXPECT_EQ(estimated_memory(request_), base + 4000 * 1500 * per_meshed_pixel + 8000 * 3000 * per_pixel);
    request_.config.disparity.working_px = 0;
    EXPECT_EQ(estimated_memory(request_), base + 8000 * 3000 * per_meshed_pixel);
    request_.source = DisparityFiles{folder_ / "view.pgm"};
    request_.config.disparity.working_px = 3000;
    EXPECT_EQ(estimated_memory(request_), base + 4000 * 3000 * per_meshed_pixel) << "maps are not reduced";
}

TEST_F(RunFiles, OutputsAreNoResultsOfStages) {
    request_.stages_folder = folder_ / "s";
    request_.outputs = {folder_ / "s/mesh2d.obj"};
    expect_one_file("the output", "a stage's result");
}

TEST_F(RunFiles, LinksAreSeenThrough) {
    fs::create_symlink("b.glb", folder_ / "dangling.glb");
    request_.outputs = {folder_ / "dangling.glb", folder_ / "b.glb"};
    expect_one_file("dangling.glb", "b.glb");
    test::write_text(folder_ / "one.glb", "");
    fs::create_hard_link(folder_ / "one.glb", folder_ / "two.glb");
    request_.outputs = {folder_ / "one.glb", folder_ / "two.glb"};
    expect_one_file("one.glb", "two.glb");
}

TEST_F(RunFiles, ATexturesTypeIsNotKnownBefore) {
    exporters::ExportConfig config;
    EXPECT_EQ(planned_files("a.obj", config),
              (std::vector<fs::path>{"a.obj", "a.mtl", "a_texture.jpg", "a_texture.png"}));
    config.texture = exporters::TextureFormat::png;
    EXPECT_EQ(planned_files("a.obj", config), (std::vector<fs::path>{"a.obj", "a.mtl", "a_texture.png"}));
}

TEST_F(RunFiles, OutputsMayShareATexture) {
    request_.outputs = {folder_ / "a.obj", folder_ / "a.gltf"};
    EXPECT_EQ(refusal_of(request_), "");
}

// By their roles, the main one first; what is in memory has none.
TEST_F(RunFiles, FilesOfASource) {
    const auto roles = [](const Source& source) {
        std::string all;
        for (const InputFile& file : files_of(source)) all += file.role + " " + file.path + ", ";
        return all;
    };
    EXPECT_EQ(roles(PairFiles{"l", "r", "m"}), "left l, right r, mask m, ");
    EXPECT_EQ(roles(StereoFile{"s"}), "stereo s, ");
    EXPECT_EQ(roles(DisparityFiles{"d", "c", "m", "f"}), "disparity d, color c, mask m, confidence f, ");
    EXPECT_EQ(roles(DepthFiles{.map = "z", .confidence = "f"}), "depth z, confidence f, ");
    EXPECT_EQ(roles(PairArrays{}) + roles(DisparityArrays{}) + roles(DepthArrays{}), "");
}

TEST_F(RunFiles, KeysThatNameFilesAreInputs) {
    request_.config.input.calibration.file = "c";
    request_.config_files = {"k"};
    const std::vector<InputFile> files = input_files(request_);
    ASSERT_EQ(files.size(), 2u);
    EXPECT_EQ(files[1].role + " " + files[1].path, "calibration c");
    EXPECT_EQ(read_files(request_), (std::vector<fs::path>{test::sample("disparity.pfm"), "c", "k"}));
}

// A calibration file may make the run rectify its pair. A map has no other view.
TEST_F(RunFiles, ARectifiedPairIsAmongTheFilesWritten) {
    request_.stages_folder = folder_ / "s";
    request_.report = folder_ / "s/calib.txt";
    request_.config.input.calibration.file = test::sample("calib.txt");
    EXPECT_EQ(refusal_of(request_), "");
    request_.source = PairFiles{test::sample("left.png"), test::sample("right.png")};
    expect_one_file("the report", "the rectified pair");
    request_.config.input.calibration.file.clear();
    EXPECT_EQ(refusal_of(request_), "");
}

TEST_F(RunFiles, NoInputIsOverwritten) {
    request_.config_files = {folder_ / "c.yaml"};
    test::write_text(request_.config_files[0], "");
    request_.report = request_.config_files[0];
    EXPECT_CONTAINS(refusal_of(request_), "would overwrite the input");
}

TEST_F(RunFiles, AllInputsCountInTheEstimate) {
    request_.outputs = {folder_ / "r.glb"};
    const std::uint64_t alone = estimated_memory(request_);
    request_.source = DisparityFiles{test::sample("disparity.pfm"), test::sample("left.png")};
    EXPECT_EQ(estimated_memory(request_), alone + 320 * 240 * 8);
}

// The header alone is read: the file holds no sample.
TEST_F(RunFiles, AMaskMuchLargerThanItsMapIsRefusedUndecoded) {
    request_.outputs = {folder_ / "r.glb"};
    const auto with_mask = [&](const std::string& size) {
        test::write_text(folder_ / "mask.pgm", "P5 " + size + " 255\n");
        request_.source = DisparityFiles{test::sample("disparity.pfm"), {}, folder_ / "mask.pgm"};
        return refusal_of(request_);
    };
    EXPECT_CONTAINS(with_mask("20000 20000"), "it has 20000x20000 px, but");
    EXPECT_EQ(with_mask("16000 12000"), "") << "the same shape";
    EXPECT_EQ(with_mask("12000 16000"), "") << "turned";
}

TEST_F(RunFiles, NamesHoldNoByteOfZero) {
    request_.outputs = {folder_ / std::string("r.glb\0.ply", 10)};
    EXPECT_CONTAINS(refusal_of(request_), "a byte of 0");
}

TEST_F(RunFiles, OutputsInAFolderOfAnotherUserAreNotOneFile) {
    std::filesystem::create_directory(folder_ / "private");
    std::filesystem::permissions(folder_ / "private", std::filesystem::perms::none);
    request_.outputs = {folder_ / "private/a.glb", folder_ / "private/b.ply"};
    const std::string refusal = refusal_of(request_);
    EXPECT_EQ(refusal.find("would be one file"), std::string::npos) << refusal;
    std::filesystem::permissions(folder_ / "private", std::filesystem::perms::owner_all);
}

}  // namespace
}  // namespace hexrelief::job
