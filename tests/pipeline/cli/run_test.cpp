// The whole job through the built program, on the synthetic pair.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "exporters/exporter.h"
#include "pipeline/files/sha256.h"
#include "tests/pipeline/process.h"

namespace hexrelief::cli {
namespace {

using namespace test;

using Json = nlohmann::json;

void expect_keys(const Json& json, std::vector<std::string> keys) {
    std::vector<std::string> found;
    for (const auto& [key, value] : json.items()) found.push_back(key);
    std::sort(keys.begin(), keys.end());
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, keys);
}

TEST(Run, WritesEveryFormatAndNamesAllFiles) {
    const TemporaryFolder folder;
    const ProcessResult result =
        expect_success(pair_arguments({"-o", folder / "a.glb", "-o", folder / "a.gltf", "-o",
                                       folder / "a.drc", "-o", folder / "a.obj", "-o", folder / "a.ply"}));
    EXPECT_EQ(result.err, "");  // calibrated: no warning; piped: no progress
    EXPECT_EQ(std::count(result.out.begin(), result.out.end(), '\n'), 2) << result.out;
    for (const char* part : {" vertices, ", " triangles, depth 1.28 to 5.",
                             "% of the picture is meshed; of its map ", "% is background; ", "cpu, ", " s\n"})
        EXPECT_CONTAINS(result.out, part);
    for (const char* name :
         {"a.glb", "a.gltf", "a.bin", "a.drc", "a.obj", "a.mtl", "a.ply", "a_texture.jpg"}) {
        ASSERT_TRUE(std::filesystem::exists(folder / name)) << name;
        std::string told = std::to_string(std::filesystem::file_size(folder / name));
        for (int at = static_cast<int>(told.size()) - 3; at > 0; at -= 3) told.insert(at, " ");
        EXPECT_CONTAINS(result.out, folder / name + " " + told + " bytes");
    }
    EXPECT_EQ(folder.entries(), 8);
    for (const char* name : {"a.glb", "a.gltf", "a.drc", "a.obj", "a.ply"})
        EXPECT_CONTAINS(run_program({"info", folder / name}).out, "triangles") << name;
}

// The views swapped: a warning, and with --strict an error before the work.
TEST(Run, StrictRefusesWhatIsOtherwiseWarnedOf) {
    const TemporaryFolder folder;
    const auto run = [&](const std::vector<std::string>& more) {
        return test::joined(
            {"--left", sample("right.png"), "--right", sample("left.png"), "--set", "mesh.spacing_px=16"},
            more);
    };
    const auto program = [](const std::vector<std::string>& options) {
        return run_program({"run"}, options);
    };
    const std::string told = "the views look swapped";
    const ProcessResult warned = program(run({"-o", folder / "a.ply", "--report", folder / "r.json"}));
    ASSERT_EQ(warned.exit_code, 0) << warned.err;
    EXPECT_CONTAINS(warned.err, "warning: " + told);
    const Json warnings = Json::parse(read_text(folder / "r.json"))["warnings"];
    EXPECT_EQ(std::count_if(warnings.begin(), warnings.end(),
                            [&](const Json& text) { return text.get<std::string>().starts_with(told); }),
              1);
    for (const std::vector<std::string>& strict :
         {std::vector<std::string>{"--strict"}, {"--set", "run.strict=true"}}) {
        const ProcessResult refused = program(test::joined(run({"-o", folder / "b.ply"}), strict));
        EXPECT_EQ(refused.exit_code, 3);
        EXPECT_CONTAINS(refused.err, told);
    }
    std::string line;
    for (const std::string& word : run({"-o", folder / "b.ply"})) line += "\"" + word + "\" ";
    write_text(folder / "jobs.txt", line + "\n");
    EXPECT_EQ(run_program({"batch", "--strict", folder / "jobs.txt"}).exit_code, 3);
    EXPECT_FALSE(std::filesystem::exists(folder / "b.ply"));
    // What is right is not refused.
    expect_success(pair_arguments({"--strict", "-o", folder / "c.ply"}));
}

TEST(Run, WritesToTheStandardOutput) {
    const TemporaryFolder folder;
    const auto arguments = [](const std::vector<std::string>& more) {
        return test::joined({"run", "--disparity", sample("disparity.pfm")}, more);
    };
    const ProcessResult named =
        run_program(arguments({"-o", folder / "a.glb", "--report", folder / "r.json"}));
    expect_success(arguments({"-o", folder / "a.drc"}));
    ASSERT_EQ(named.exit_code, 0) << named.err;
    const ProcessResult glb = run_program(arguments({"-o", "-"}));
    EXPECT_TRUE(glb.out == read_text(folder / "a.glb"));
    EXPECT_CONTAINS(glb.err, " vertices, ");
    EXPECT_TRUE(run_program(arguments({"-o", "drc:-"})).out == read_text(folder / "a.drc"));
    const ProcessResult report = run_program(arguments({"-o", folder / "b.glb", "--report", "-"}));
    EXPECT_EQ(Json::parse(report.out)["surface"], Json::parse(read_text(folder / "r.json"))["surface"]);
}

TEST(Run, MakesTheFoldersOfItsFiles) {
    const TemporaryFolder folder;
    const std::string map = sample("disparity.pfm"), mesh = folder / "new/deep/a.obj";
    expect_success({"run", "--disparity", map, "-o", mesh, "--report", folder / "other/r.json"});
    EXPECT_TRUE(std::filesystem::exists(mesh) && std::filesystem::exists(folder / "new/deep/a.mtl"));
    EXPECT_TRUE(std::filesystem::exists(folder / "other/r.json"));
}

TEST(Run, SaysThatAMapWithoutColorHasNone) {
    const TemporaryFolder folder;
    const auto said = [&](const std::vector<std::string>& more) {
        return run_program({"run", "--disparity", sample("disparity.pfm"), "-o"}, more).out.find("--color") !=
               std::string::npos;
    };
    EXPECT_TRUE(said({folder / "a.glb"}));
    EXPECT_FALSE(said({folder / "a.glb", "--color", sample("left.png")}));
    EXPECT_FALSE(said({folder / "a.drc"})) << "it holds no texture";
}

TEST(Run, QuietSaysNothing) {
    const TemporaryFolder folder;
    const ProcessResult result = expect_success({"run", "--left", sample("left.png"), "--right",
                                                 sample("right.png"), "-o", folder / "a.drc", "--quiet"});
    EXPECT_EQ(result.out + result.err, "");
}

TEST(Run, WithoutCalibrationWarnsOnceAndIsRelative) {
    const TemporaryFolder folder;
    const ProcessResult result = expect_success({"run", "--disparity", sample("disparity.pfm"), "-o",
                                                 folder / "a.drc", "--report", folder / "r.json"});
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    const Json report = Json::parse(read_text(folder / "r.json"));
    EXPECT_EQ(report["warnings"].size(), 1u);
    EXPECT_EQ(report["input"]["calibration"]["metric"], false);
    EXPECT_EQ(report["surface"]["metric"], false);
}

TEST(Run, ReportFollowsTheSchema) {
    const TemporaryFolder folder;
    expect_success(
        pair_arguments({"-o", folder / "a.glb", "-o", folder / "a.obj", "--report", folder / "r.json",
                        "--seed", "7", "--threads", "2", "--set", "mesh.spacing_px=8"}));
    const Json report = Json::parse(read_text(folder / "r.json"));
    expect_keys(report, {"schema",        "hexrelief", "backend",     "backend_reason", "device",
                         "threads",       "seed",      "config",      "input",          "foreground_share",
                         "background_px", "picture",   "depth_range", "disparity",      "stages",
                         "mesh",          "surface",   "budget",      "outputs",        "warnings",
                         "seconds",       "peak_bytes"});
    EXPECT_TRUE(report["budget"].is_null());
    EXPECT_EQ(report["schema"], 1);
    EXPECT_EQ(report["hexrelief"]["version"], HEXRELIEF_VERSION);
    EXPECT_EQ(report["backend"], "cpu");
    EXPECT_EQ(report["threads"], 2);
    EXPECT_EQ(report["seed"], 7);
    EXPECT_EQ(report["config"]["mesh"]["spacing_px"], 8);
    EXPECT_EQ(report["config"]["mesh"]["seed"], 7);
    expect_keys(report["input"], {"paths", "width", "height", "sha256", "calibration", "known_share",
                                  "densified", "believed", "quantum_px", "reduced_by", "alignment"});
    expect_keys(report["input"]["calibration"], {"focal_px", "cx", "cy", "baseline_m", "doffs_px", "metric"});
    EXPECT_EQ(report["input"]["calibration"]["metric"], true);
    expect_keys(report["disparity"], {"method", "min_disparity_px", "num_disparities_px", "matched_share",
                                      "filled_share", "support", "support_word", "noise_px", "backdrop"});
    EXPECT_EQ(report["disparity"]["support_word"], "good");
    expect_keys(report["disparity"]["backdrop"], {"depth", "moved_share"});
    EXPECT_LE(report["depth_range"][1].get<double>(),
              report["disparity"]["backdrop"]["depth"].get<double>() + 1e-3);
    const Json& picture = report["picture"];
    expect_keys(picture, {"meshed_share", "background_share", "unknown_share", "occluded_share"});
    EXPECT_NEAR(picture["background_share"].get<double>() + report["foreground_share"].get<double>(),
                report["input"]["known_share"], 1e-12);
    EXPECT_NEAR(picture["meshed_share"], report["foreground_share"], 0.01);
    EXPECT_EQ(report["depth_range"][0].get<double>(), -report["surface"]["bounds"][1][2].get<double>());
    EXPECT_GT(report["seconds"].get<double>(), report["stages"][0]["seconds"].get<double>());
    EXPECT_GT(report["peak_bytes"].get<double>(), 1 << 20);
    EXPECT_EQ(report["input"]["sha256"]["left"], files::sha256_of_file(sample("left.png")));
    expect_keys(report["mesh"], {"columns", "rows", "vertices", "triangles", "iterations", "device_seconds",
                                 "device_balance_seconds", "device_surface_seconds", "device_bytes",
                                 "percent_cost", "max_deviation_percent", "inverted_triangles",
                                 "min_angle_deg", "honeycomb_cells", "weights_percent", "angles_deg"});
    EXPECT_EQ(report["mesh"]["device_bytes"] > 0, report["backend"] == "cuda");
    EXPECT_EQ(report["mesh"]["device_seconds"] > 0, report["backend"] == "cuda");
    const Json &weights = report["mesh"]["weights_percent"], &angles = report["mesh"]["angles_deg"];
    expect_keys(weights, {"p5", "p50", "p95"});
    expect_keys(angles, {"min", "p1", "median"});
    EXPECT_LT(weights["p5"], weights["p50"]);
    EXPECT_LT(weights["p50"], weights["p95"]);
    EXPECT_NEAR(weights["p50"].get<double>(), 100, 25);
    EXPECT_EQ(angles["min"], report["mesh"]["min_angle_deg"]);
    EXPECT_LT(angles["min"], angles["p1"]);
    EXPECT_LT(angles["p1"], angles["median"]);
    EXPECT_EQ(report["mesh"]["vertices"],
              report["mesh"]["columns"].get<int>() * report["mesh"]["rows"].get<int>());
    EXPECT_EQ(report["mesh"]["inverted_triangles"], 0);
    const Json& surface = report["surface"];
    expect_keys(surface,
                {"vertices", "triangles", "components", "boundary_loops", "bounds", "metric",
                 "right_triangles", "hidden_triangles", "rmse_near_px", "duo_rmse_near_px", "flat_rmse_px",
                 "sheet_share", "hole_share", "hole_share_above", "coverage", "slack_coverage"});
    EXPECT_GT(surface["flat_rmse_px"], 0);
    EXPECT_LT(surface["flat_rmse_px"], surface["rmse_near_px"]);
    EXPECT_GT(surface["coverage"], 0.5);
    EXPECT_LE(surface["coverage"], surface["slack_coverage"]);
    for (int axis = 0; axis < 3; ++axis)
        EXPECT_LT(report["surface"]["bounds"][0][axis].get<double>(),
                  report["surface"]["bounds"][1][axis].get<double>());
    EXPECT_LT(report["surface"]["bounds"][1][2].get<double>(),
              0);  // in front of the camera, which looks along -Z
    ASSERT_EQ(report["outputs"].size(), 4u);
    for (const Json& output : report["outputs"]) {
        expect_keys(output, {"path", "format", "bytes", "sha256"});
        const std::string path = output["path"];
        EXPECT_EQ(output["bytes"], std::filesystem::file_size(path));
        EXPECT_EQ(output["sha256"], files::sha256_of_file(path));
    }
    EXPECT_EQ(report["outputs"][0]["format"], "glb");
    ASSERT_GE(report["stages"].size(), 6u);
    for (const Json& stage : report["stages"]) expect_keys(stage, {"name", "seconds"});
    EXPECT_TRUE(report["warnings"].empty());
}

TEST(Run, SameBytesForAnyNumberOfThreadsAndEveryTime) {
    const TemporaryFolder folder;
    const std::vector<std::string> runs = {"1", "2", "2", "5"};
    for (std::size_t i = 0; i < runs.size(); ++i) {
        const std::string to = folder / std::to_string(i);
        std::filesystem::create_directory(to);
        std::vector<std::string> arguments = {"--threads",    runs[i], "--save-stages",
                                              to + "/stages", "--set", "export.compression=draco"};
        for (const char* extension : {"glb", "gltf", "drc", "obj", "ply"})
            arguments.insert(arguments.end(), {"-o", to + "/a." + extension});
        expect_success(pair_arguments(arguments));
    }
    std::size_t compared = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder / "0")) {
        if (!entry.is_regular_file()) continue;
        ++compared;
        const auto relative = std::filesystem::relative(entry.path(), folder / "0").string();
        for (const char* other : {"1", "2", "3"})
            EXPECT_TRUE(read_text(entry.path()) == read_text(folder / (std::string(other) + "/" + relative)))
                << relative << " " << other;
    }
    EXPECT_EQ(compared,
              16u + 2u);  // 8 meshes' files less the two that .glb and .ply do not add, and 10 stage files
}

TEST(Run, LevelsOfDetailBesideAndInside) {
    const TemporaryFolder folder;
    const ProcessResult result =
        expect_success(pair_arguments({"-o", folder / "a.glb", "-o", folder / "a.obj", "-o", folder / "a.drc",
                                       "--report", folder / "r.json", "--set", "export.lod=3"}));
    EXPECT_EQ(result.err.find("MSFT_lod"), std::string::npos) << result.err;
    const Json report = Json::parse(read_text(folder / "r.json"));
    ASSERT_EQ(report["levels"].size(), 2u);
    EXPECT_EQ(report["levels"][0]["spacing_px"], 12);
    EXPECT_EQ(report["levels"][1]["spacing_px"], 24);
    EXPECT_LT(report["levels"][0]["vertices"].get<int>() * 2, report["surface"]["vertices"].get<int>());
    EXPECT_LT(report["levels"][1]["triangles"].get<int>() * 2, report["levels"][0]["triangles"].get<int>());
    EXPECT_EQ(exporters::describe_mesh(folder / "a.glb").coarser.size(), 0u);
    for (int level : {1, 2}) {
        const Json& told = report["levels"][level - 1];
        const std::string stem = folder / ("a.lod" + std::to_string(level));
        EXPECT_EQ(exporters::describe_mesh(stem + ".glb").vertices, told["vertices"].get<int>());
        EXPECT_EQ(exporters::describe_mesh(stem + ".obj").triangles, told["triangles"].get<int>());
        const auto of_left_view = exporters::describe_mesh(stem + ".drc").triangles;
        EXPECT_LT(of_left_view, told["triangles"].get<int>());
        EXPECT_GT(2 * of_left_view, told["triangles"].get<int>());
    }
    EXPECT_EQ(report["outputs"].size(), 3u * (1 + 3 + 1));
    EXPECT_EQ(folder.entries(), 3 * (1 + 3 + 1) + 1);
    const ProcessResult inside = expect_success(pair_arguments(
        {"-o", folder / "b.glb", "--set", "export.lod=3", "--set", "export.lod_storage=inside"}));
    EXPECT_CONTAINS(inside.err, "b.glb on top of each other");
    const inspect::MeshDescription glb = exporters::describe_mesh(folder / "b.glb");
    ASSERT_EQ(glb.coarser.size(), 2u);
    for (int level : {1, 2})
        EXPECT_EQ(glb.coarser[level - 1].vertices, report["levels"][level - 1]["vertices"].get<int>());
}

TEST(Run, LevelsOfDetailThatCannotBeAreUsageErrors) {
    const TemporaryFolder folder;
    const ProcessResult coarse =
        run_program(pair_arguments({"-o", folder / "a.glb", "--set", "export.lod=8"}));
    EXPECT_EQ(coarse.exit_code, 2);
    EXPECT_CONTAINS(coarse.err, "export.lod");
    const ProcessResult clash = run_program(
        pair_arguments({"-o", folder / "a.obj", "-o", folder / "a.lod1.obj", "--set", "export.lod=2"}));
    EXPECT_EQ(clash.exit_code, 2);
    EXPECT_CONTAINS(clash.err, "a.lod1.obj");
    EXPECT_EQ(folder.entries(), 0);
}

TEST(Run, SeedChangesTheMesh) {
    const TemporaryFolder folder;
    expect_success(pair_arguments({"-o", folder / "a.ply", "--seed", "1"}));
    expect_success(pair_arguments({"-o", folder / "b.ply", "--seed", "2"}));
    EXPECT_NE(read_text(folder / "a.ply"), read_text(folder / "b.ply"));
}

TEST(Run, SavesEveryStage) {
    const TemporaryFolder folder;
    expect_success({"run", "--disparity", sample("disparity.pfm"), "--color", sample("left.png"), "--calib",
                    sample("calib.txt"), "--save-stages", folder / "new/stages"});
    for (const char* name : {"disparity.pfm", "disparity.png", "density.pfm", "density.png", "samples.png",
                             "mesh2d.obj", "mesh2d.png", "weights.png", "relief.png", "depth.exr"})
        EXPECT_GT(std::filesystem::file_size(folder / (std::string("new/stages/") + name)), 100u) << name;
    // A supplied map goes through unchanged.
    const ProcessResult same =
        run_program({"evaluate", folder / "new/stages/disparity.pfm", sample("disparity.pfm"), "--json"});
    EXPECT_EQ(Json::parse(same.out)["rms_error_px"], 0);
}

TEST(Run, MatchesTheSyntheticPair) {
    const TemporaryFolder folder;
    expect_success(pair_arguments({"--save-stages", folder.path().string()}));
    const ProcessResult result =
        run_program({"evaluate", folder / "disparity.pfm", sample("disparity.pfm"), "--json"});
    const Json json = Json::parse(result.out);
    EXPECT_LT(json["average_error_px"].get<double>(), 1.0);
    EXPECT_LT(json["bad_2_percent"].get<double>(), 25.0);
}

TEST(Run, ExplicitCalibrationOverridesAndScalesDepth) {
    const TemporaryFolder folder;
    for (const char* baseline : {"0.1", "0.2"})
        expect_success({"run", "--disparity", sample("disparity.pfm"), "--set",
                        "input.calibration.focal_px=500", "--set",
                        std::string("input.calibration.baseline_m=") + baseline, "--report",
                        folder / (std::string(baseline) + ".json")});
    const Json near = Json::parse(read_text(folder / "0.1.json")),
               far = Json::parse(read_text(folder / "0.2.json"));
    EXPECT_EQ(near["surface"]["metric"], true);
    EXPECT_NEAR(far["surface"]["bounds"][0][2].get<double>(),
                2 * near["surface"]["bounds"][0][2].get<double>(), 1e-5);
}

TEST(Run, FailureAtTheEndLeavesNothingNew) {
    // The stages' folder cannot be made once the meshes are written: its name is an output's companion.
    const TemporaryFolder folder;
    const ProcessResult result = run_program(
        pair_arguments({"-o", folder / "a.glb", "-o", folder / "a.obj", "--save-stages", folder / "a.mtl"}));
    EXPECT_EQ(result.exit_code, 4) << result.err;
    EXPECT_EQ(folder.entries(), 0);
}

}  // namespace
}  // namespace hexrelief::cli
