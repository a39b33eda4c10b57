// The public functions, against the job that the command line does.
#include <hexrelief/run.h>

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "pipeline/config/options.h"
#include "pipeline/job/runner.h"
#include "tests/temporary_folder.h"

namespace hexrelief {
namespace {

namespace fs = std::filesystem;

std::string sample(const std::string& name) {
    return std::string(HEXRELIEF_SOURCE_DIR) + "/samples/" + name;
}

class Library : public testing::Test {
  protected:
    std::string file(const std::string& name) const { return (folder_ / name).string(); }
    // What the command line writes.
    std::string expected(const std::vector<std::string>& settings, const std::string& name = "expected.glb") {
        job::RunRequest request{.source = job::DisparityFiles{sample("disparity.pfm"), sample("left.png")},
                                .outputs = {file(name)},
                                .config = config::read_config({}, settings)};
        request.config.input.calibration.file = sample("calib.txt");
        job::run_job(request);
        return test::read_text(file(name));
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

    const test::Folder folder_;
    const Disparities disparity_ = read_disparities(sample("disparity.pfm"));
    const Picture left_ = read_picture(sample("left.png"));
    const Camera camera_{.file = sample("calib.txt")};
    const Options coarse_{.settings = {{"mesh.spacing_px", "12"}}};
};

TEST_F(Library, WritesTheBytesOfTheCommandLine) {
    const Mesh made = mesh(disparity_.view(), left_.view(), camera_, coarse_);
    EXPECT_EQ(made.save(file("a.glb")), std::vector<std::string>{file("a.glb")});
    EXPECT_EQ(test::read_text(file("a.glb")), expected({"mesh.spacing_px=12"}));
    made.save(file("b.glb"), {.settings = {{"export.compression", "draco"}, {"export.tolerance_px", "0.2"}}});
    EXPECT_EQ(test::read_text(file("b.glb")),
              expected({"mesh.spacing_px=12", "export.compression=draco", "export.tolerance_px=0.2"}));
    made.save(file("c.glb"));
    EXPECT_EQ(test::read_text(file("c.glb")), test::read_text(file("a.glb")))
        << "settings are those of one call";
}

TEST_F(Library, MatchesAsTheCommandLineDoes) {
    job::RunRequest request{.source = job::PairFiles{sample("left.png"), sample("right.png")},
                            .outputs = {file("pair.glb")}};
    request.config.input.calibration.file = sample("calib.txt");
    request.config.surface.views = SurfaceViews::left;  // a map has no other view
    request.config.given.insert("surface.behind");      // nor is it turned by so much
    job::run_job(request);
    const Picture right = read_picture(sample("right.png"));
    const Disparities found = compute_disparity(left_.view(), right.view(), camera_);
    mesh(found.view(), left_.view(), camera_, {.settings = {{"surface.views", "left"}}})
        .save(file("found.glb"));
    EXPECT_EQ(test::read_text(file("found.glb")), test::read_text(file("pair.glb")));
}

TEST_F(Library, MatchesPicturesInMemoryAtTheirOwnSize) {
    Picture wide{2 * left_.width, 2 * left_.height, 1, {}};
    for (int y = 0; y < wide.height; ++y)
        for (int x = 0; x < wide.width; ++x)
            wide.pixels.push_back(
                left_.pixels[static_cast<std::size_t>(y / 2 * left_.width + x / 2) * left_.channels]);
    const Options options{
        .settings = {{"disparity.working_px", "320"}, {"disparity.num_disparities_px", "16"}}};
    EXPECT_EQ(compute_disparity(wide.view(), wide.view(), {}, options).width, wide.width);
}

TEST_F(Library, MeshesDepthsAndMasksAsTheCommandLineDoes) {
    const auto pixels = static_cast<std::size_t>(disparity_.width) * disparity_.height;
    std::vector<float> depth(pixels);
    std::vector<std::uint8_t> mask(pixels), confidence(pixels);
    for (std::size_t i = 0; i < pixels; ++i) {
        depth[i] = disparity_.values[i] < 1e6f ? 100 / disparity_.values[i] : 0;
        mask[i] = i % disparity_.width > 40;
        confidence[i] = i % disparity_.width < 150 ? 255 : 3;
    }
    const auto write = [&](const std::string& name, const std::string& head, const void* values,
                           std::size_t bytes) {
        std::ofstream out(file(name), std::ios::binary);
        out << head;
        out.write(static_cast<const char*>(values), static_cast<std::streamsize>(bytes));
        return file(name);
    };
    const int width = disparity_.width, height = disparity_.height;
    const std::string size = std::to_string(width) + " " + std::to_string(height);
    std::vector<float> upwards;  // as PFM has its rows
    for (int y = height - 1; y >= 0; --y)
        upwards.insert(upwards.end(), depth.begin() + y * width, depth.begin() + (y + 1) * width);
    FileRequest files{.color = sample("left.png"), .outputs = {file("files.glb")}};
    files.depth = write("d.pfm", "Pf\n" + size + "\n-1\n", upwards.data(), pixels * sizeof(float));
    files.mask = write("m.pgm", "P5\n" + size + "\n255\n", mask.data(), pixels);
    files.confidence = write("c.pgm", "P5\n" + size + "\n255\n", confidence.data(), pixels);
    Options options = coarse_;
    options.direct = {{"--calib", sample("calib.txt")}, {"--depth-unit", "2"}};
    run(files, options);
    MapInput input{.depth = {depth.data(), width, height}, .color = left_.view()};
    input.mask = {mask.data(), width, height, 1};
    input.confidence = {confidence.data(), width, height, MapView::Samples::uint8};
    const Mesh made = mesh_input(input, {}, options);
    made.save(file("arrays.glb"));
    EXPECT_EQ(test::read_text(file("arrays.glb")), test::read_text(file("files.glb")));
    EXPECT_LT(made.face_count(), mesh_input({.depth = input.depth}, {}, options).face_count());
    input.disparity = disparity_.view();
    EXPECT_EQ(refusal([&] { mesh_input(input); }).first, ErrorKind::usage);
}

TEST_F(Library, RunsFromFilesToFiles) {
    const std::string reference = expected({"mesh.spacing_px=12"});
    FileRequest files{.disparity = sample("disparity.pfm"), .color = sample("left.png")};
    files.outputs = {file("run.glb")};
    files.report = file("run.json");
    std::vector<std::string> begun, ended;
    Options options = coarse_;
    options.direct = {{"--calib", sample("calib.txt")}};
    options.progress = [&](const std::string& stage, double share) {
        if (share == 0 && (begun.empty() || begun.back() != stage)) begun.push_back(stage);
    };
    options.stage_ended = [&](const std::string& stage, double) { ended.push_back(stage); };
    check_run(files, options);
    EXPECT_FALSE(fs::exists(file("run.glb")));
    const RunSummary summary = run(files, options);
    EXPECT_EQ(test::read_text(file("run.glb")), reference);
    ASSERT_EQ(summary.outputs.size(), 1u);
    EXPECT_EQ(summary.outputs[0].bytes, reference.size());
    EXPECT_TRUE(summary.is_metric && !summary.lacks_color && summary.budget.kind.empty());
    EXPECT_GT(summary.farthest, summary.nearest);
    EXPECT_NE(test::read_text(file("run.json")).find("\"triangles\": " + std::to_string(summary.triangles)),
              std::string::npos);
    EXPECT_EQ(begun.size(), ended.size());
    EXPECT_EQ(begun.front(), "input");
    EXPECT_EQ(ended.back(), "measures") << "for the report, while files are written";
}

TEST_F(Library, RefusesRunsAsTheCommandLineDoes) {
    const auto with = [&](const std::string& option, const std::string& value) {
        FileRequest files{.disparity = sample("disparity.pfm"), .outputs = {file("a.glb")}};
        return refusal([&] { check_run(files, {.direct = {{option, value}}}); });
    };
    EXPECT_EQ(with("--depth-unit", "mm").second, "--depth-unit goes with --depth, which is not given");
    EXPECT_EQ(with("--threads", "-1").second.substr(0, 9), "--threads");
    EXPECT_EQ(with("--output", "b.glb"),
              std::pair(ErrorKind::usage, std::string("'--output' stands for no key")));
    FileRequest none{.disparity = file("none.pfm"), .outputs = {file("a.glb")}};
    EXPECT_EQ(refusal([&] { run(none); }).first, ErrorKind::input);
    EXPECT_FALSE(uses_standard_output(none));
    none.outputs = {"drc:-"};
    EXPECT_TRUE(uses_standard_output(none));
    EXPECT_TRUE(output_extensions().starts_with(".glb ")) << output_extensions();
    EXPECT_TRUE(output_streams().starts_with("glb:-, ")) << output_streams();
}

TEST_F(Library, RefusesFilesThatDoNotGoTogether) {
    const auto told = [&](FileRequest files) {
        files.outputs = {file("a.glb")};
        return refusal([&] { check_run(files); }).second;
    };
    const std::string left = sample("left.png"), right = sample("right.png"), map = sample("disparity.pfm");
    EXPECT_EQ(told({}), "nothing to do: give --left and --right, --stereo, --disparity, or --depth");
    EXPECT_EQ(told({.left = left}), "--left needs --right");
    EXPECT_EQ(told({.left = left, .right = right, .stereo = left}).substr(0, 27),
              "--stereo holds both views; ");
    EXPECT_EQ(told({.left = left, .right = right, .confidence = map}).substr(0, 35),
              "--confidence goes with --disparity ");
    EXPECT_EQ(told({.disparity = map, .depth = map}), "give either --disparity or --depth, not both");
    EXPECT_EQ(told({.left = left, .disparity = map}).substr(0, 36), "a map takes its colours from --color");
    EXPECT_EQ(told({.left = left, .right = right}), "nothing was refused");
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
    EXPECT_EQ(test::read_text(file("a.ply")), test::read_text(file("b.ply")));
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
    EXPECT_TRUE(fs::is_empty(folder_.path()));
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
    EXPECT_EQ(stages.back(), "quality");
    EXPECT_FALSE(warned.empty()) << "nothing is known of the camera";
    options.progress = [](const std::string& stage, double) {
        if (stage == "mesh") throw 42;
    };
    EXPECT_THROW(mesh(disparity_.view(), {}, {}, options), int);
    mesh(disparity_.view(), {}, {}, coarse_);  // and goes on working
}

}  // namespace
}  // namespace hexrelief
