// The public functions, against the job that the command line does.
#include <hexrelief/hexrelief.h>

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "pipeline/config/options.h"
#include "pipeline/job/runner.h"

namespace hexrelief {
namespace {

namespace fs = std::filesystem;

std::string sample(const std::string& name) {
    return std::string(HEXRELIEF_SOURCE_DIR) + "/samples/" + name;
}

class Library : public testing::Test {
  protected:
    Library() : folder_(fs::path(testing::TempDir()) / ("library-" + std::to_string(getpid()))) {
        fs::create_directories(folder_);
    }
    ~Library() override { fs::remove_all(folder_); }
    std::string file(const std::string& name) const { return (folder_ / name).string(); }
    static std::string bytes(const std::string& path) {
        std::ifstream in(path, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    // What the command line writes.
    std::string expected(const std::vector<std::string>& settings, const std::string& name = "expected.glb") {
        RunRequest request;
        request.disparity = sample("disparity.pfm");
        request.color = sample("left.png");
        request.config = read_config({"", settings}, {});
        request.config.input.calibration.file = sample("calib.txt");
        request.outputs = {file(name)};
        run_job(request, {});
        return bytes(file(name));
    }
    template <typename Call>
    static std::pair<ErrorKind, std::string> refusal(const Call& call) {
        try {
            call();
        } catch (const Error& error) {
            return {error.kind(), error.what()};
        }
        return {ErrorKind::device, "nothing was refused"};
    }

    const fs::path folder_;
    const Disparities disparity_ = read_disparities(sample("disparity.pfm"));
    const Picture left_ = read_picture(sample("left.png"));
    const Camera camera_{.file = sample("calib.txt")};
    const Options coarse_{.settings = {{"mesh.spacing_px", "12"}}};
};

TEST_F(Library, WritesTheBytesOfTheCommandLine) {
    const Mesh made = mesh(disparity_.view(), left_.view(), camera_, coarse_);
    EXPECT_EQ(made.save(file("a.glb")), std::vector<std::string>{file("a.glb")});
    EXPECT_EQ(bytes(file("a.glb")), expected({"mesh.spacing_px=12"}));
    made.save(file("b.glb"), {.settings = {{"export.compression", "draco"}, {"export.tolerance_px", "0.2"}}});
    EXPECT_EQ(bytes(file("b.glb")),
              expected({"mesh.spacing_px=12", "export.compression=draco", "export.tolerance_px=0.2"}));
    made.save(file("c.glb"));
    EXPECT_EQ(bytes(file("c.glb")), bytes(file("a.glb"))) << "settings are those of one call";
}

TEST_F(Library, MatchesAsTheCommandLineDoes) {
    RunRequest request;
    request.left = sample("left.png");
    request.right = sample("right.png");
    request.config.input.calibration.file = sample("calib.txt");
    request.outputs = {file("pair.glb")};
    run_job(request, {});
    const Picture right = read_picture(sample("right.png"));
    const Disparities found = compute_disparity(left_.view(), right.view(), camera_);
    mesh(found.view(), left_.view(), camera_).save(file("found.glb"));
    EXPECT_EQ(bytes(file("found.glb")), bytes(file("pair.glb")));
}

TEST_F(Library, TellsOfTheMesh) {
    const Mesh made = mesh(disparity_.view(), {}, camera_, coarse_);
    EXPECT_TRUE(made.is_metric());
    ASSERT_GT(made.face_count(), 100u);
    for (std::size_t i = 0; i < 3 * made.face_count(); ++i) ASSERT_LT(made.faces()[i], made.vertex_count());
    for (std::size_t i = 0; i < made.vertex_count(); ++i) {
        ASSERT_LT(made.vertices()[3 * i + 2], 0) << "in front of the camera";
        ASSERT_TRUE(made.uv()[2 * i] >= 0 && made.uv()[2 * i] <= 1);
    }
    EXPECT_GT(made.lattice_columns() * made.lattice_rows(), 100);
    EXPECT_NE(made.report().find("\"percent_cost\""), std::string::npos);
    made.save(file("a.obj"));
    EXPECT_NE(made.report().find(file("a.obj")), std::string::npos);
}

TEST_F(Library, TakesRowsWithGapsAndIntegers) {
    const int width = disparity_.width, height = disparity_.height;
    std::vector<std::uint16_t> wide(static_cast<std::size_t>(width + 5) * height, 7777);
    std::vector<float> rounded(static_cast<std::size_t>(width) * height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const std::size_t at = static_cast<std::size_t>(y) * width + x;
            const float d = disparity_.values[at];
            const auto raw = static_cast<std::uint16_t>(d < 200 ? 256 * d : 0);
            wide[static_cast<std::size_t>(y) * (width + 5) + x] = raw;
            rounded[at] = static_cast<float>(raw) / 256;
        }
    const MapView gaps{wide.data(), width, height, MapView::Samples::uint16,
                       2 * static_cast<std::size_t>(width + 5)};
    mesh(gaps, left_.view(), camera_, coarse_).save(file("a.ply"));
    mesh({rounded.data(), width, height}, left_.view(), camera_, coarse_).save(file("b.ply"));
    EXPECT_EQ(bytes(file("a.ply")), bytes(file("b.ply")));
}

TEST_F(Library, RefusesAsTheCommandLineDoes) {
    const auto with = [&](const std::string& key, const std::string& value) {
        return refusal([&] { mesh(disparity_.view(), {}, camera_, {.settings = {{key, value}}}); });
    };
    EXPECT_EQ(with("density.backgroud", "0.1").first, ErrorKind::usage);
    EXPECT_NE(with("density.backgroud", "0.1").second.find("did you mean"), std::string::npos);
    EXPECT_EQ(with("run.backend", "tpu").first, ErrorKind::usage);
    const std::vector<float> nothing(100, 0.0f);
    const auto empty = refusal([&] { mesh({nothing.data(), 10, 10}); });
    EXPECT_EQ(empty.first, ErrorKind::input);
    EXPECT_NE(empty.second.find("no pixel of the map is known"), std::string::npos) << empty.second;
    EXPECT_EQ(refusal([] { mesh({}); }).first, ErrorKind::input);
    const Picture right{10, 10, 3, std::vector<std::uint8_t>(300)};
    EXPECT_EQ(refusal([&] { compute_disparity(left_.view(), right.view()); }).first, ErrorKind::input);
    EXPECT_EQ(refusal([&] { mesh(disparity_.view(), right.view()); }).first, ErrorKind::input);

    const Mesh made = mesh(disparity_.view(), {}, camera_, coarse_);
    EXPECT_EQ(refusal([&] { made.save(file("a.xyz")); }).first, ErrorKind::usage);
    EXPECT_EQ(refusal([&] { made.save("/proc/none/a.glb"); }).first, ErrorKind::output);
    EXPECT_EQ(refusal([&] { made.save(file("a.glb"), coarse_); }).first, ErrorKind::usage);
    EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(Library, TellsProgressAndStopsWhenTold) {
    std::vector<std::string> stages;
    Options options = coarse_;
    options.progress = [&](const std::string& stage, double share) {
        if (share == 0) stages.push_back(stage);
    };
    std::string warned;
    options.warn = [&](const std::string& warning) { warned = warning; };
    mesh(disparity_.view(), {}, {}, options);
    EXPECT_EQ(stages.front(), "input");
    EXPECT_EQ(stages.back(), "surface");
    EXPECT_FALSE(warned.empty()) << "nothing is known of the camera";
    options.progress = [](const std::string& stage, double) {
        if (stage == "mesh") throw 42;
    };
    EXPECT_THROW(mesh(disparity_.view(), {}, {}, options), int);
    mesh(disparity_.view(), {}, {}, coarse_);  // and goes on working
}

}  // namespace
}  // namespace hexrelief
