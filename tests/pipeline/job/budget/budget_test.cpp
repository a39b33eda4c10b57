// Tests budgets instead of a spacing, by the built program.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "exporters/images/image_writer.h"
#include "tests/pipeline/process.h"

namespace hexrelief::job {
namespace {

using namespace test;

using Json = nlohmann::json;

struct Outcome {
    ProcessResult process;
    Json report;
    std::uintmax_t bytes = 0;
};

// Runs on the sample's map with more options, and expects an exit code.
Outcome run_map(const TemporaryFolder& folder, const std::string& name, const std::vector<std::string>& extra,
                int exit_code = 0) {
    Outcome outcome{run_program({"run", "--disparity", sample("disparity.pfm"), "--calib",
                                 sample("calib.txt"), "--report", folder / "r.json", "-o", folder / name},
                                extra),
                    {},
                    0};
    EXPECT_EQ(outcome.process.exit_code, exit_code) << outcome.process.err;
    if (outcome.process.exit_code != 0) return outcome;
    outcome.report = Json::parse(read_text(folder / "r.json"));
    outcome.bytes = std::filesystem::file_size(folder / name);
    return outcome;
}

TEST(Budget, VerticesAreKeptAndNearlyUsed) {
    const TemporaryFolder folder;
    for (const int limit : {400, 3000}) {
        const Outcome o = run_map(folder, "a.drc", {"--vertices", std::to_string(limit)});
        const int vertices = o.report["surface"]["vertices"];
        EXPECT_LE(vertices, limit);
        EXPECT_GT(vertices, 0.85 * limit);
        const Json& budget = o.report["budget"];
        EXPECT_EQ(budget["kind"], "vertices");
        EXPECT_EQ(budget["limit"], limit);
        EXPECT_EQ(budget["reached"], vertices);
        EXPECT_EQ(budget["spacing_px"], o.report["config"]["mesh"]["spacing_px"]);
        EXPECT_GE(budget["solves"], 1);
        EXPECT_CONTAINS(o.process.out,
                        limit == 3000 ? "budget vertices 3 000: reached " : "budget vertices 400: ");
    }
}

TEST(Budget, BytesAreThoseOfTheFile) {
    const TemporaryFolder folder;
    const Outcome o = run_map(folder, "a.drc", {"--max-bytes", "9000"});
    EXPECT_LE(o.bytes, 9000u);
    EXPECT_GT(o.bytes, 7000u);
    EXPECT_EQ(o.report["budget"]["reached"], o.bytes);
    EXPECT_EQ(o.report["budget"]["tolerance_px"], o.report["config"]["export"]["tolerance_px"]);
}

// Pages contain pictures of the stages, and levels of detail are coarser than the mesh.
TEST(Budget, BytesCountPicturesAndLevels) {
    const TemporaryFolder folder;
    const auto expect_within = [&](const char* file, int most, std::vector<std::string> extra) {
        extra.insert(extra.end(), {"--max-bytes", std::to_string(most)});
        const Outcome o = run_map(folder, file, extra);
        std::uintmax_t bytes = 0;
        for (const Json& output : o.report["outputs"]) bytes += output["bytes"].get<std::uintmax_t>();
        EXPECT_EQ(o.report["budget"]["reached"], bytes) << file;
        EXPECT_LE(bytes, most) << file;
    };
    expect_within("page.html", 620000, {});
    expect_within("levels.glb", 36000, {"--set", "export.lod=3"});
    expect_within("scene.usdz", 60000, {"--color", sample("left.png")});
}

// A texture and the files beside the mesh count as well.
TEST(Budget, BytesCountEveryFileOfAnOutput) {
    const TemporaryFolder folder;
    const Outcome o = run_map(folder, "a.gltf", {"--color", sample("left.png"), "--max-bytes", "120000"});
    std::uintmax_t bytes = 0;
    for (const Json& output : o.report["outputs"]) bytes += output["bytes"].get<std::uintmax_t>();
    EXPECT_EQ(o.report["outputs"].size(), 3u);
    EXPECT_LE(bytes, 120000u);
    EXPECT_EQ(o.report["budget"]["reached"], bytes);
    EXPECT_GT(bytes, 80000u);
}

Json texture_of(const Outcome& o) {
    return {o.report["config"]["export"]["texture_quality"], o.report["config"]["export"]["texture_max_px"]};
}

TEST(Budget, TheTextureTakesPart) {
    const TemporaryFolder folder;
    std::uintmax_t least = 1000000;
    for (const char* limit : {"100000", "12000"}) {
        const Outcome o = run_map(folder, "a.glb", {"--color", sample("left.png"), "--max-bytes", limit});
        EXPECT_LE(o.bytes, std::stoul(limit));
        EXPECT_LT(o.bytes, least);
        least = o.bytes;
        const Json& budget = o.report["budget"];
        EXPECT_EQ(texture_of(o), Json({budget["texture_quality"], budget["texture_max_px"]}));
        if (std::string(limit) == "100000") {
            EXPECT_EQ(texture_of(o), Json({90, 0})) << "there is room for the configured one";
        } else {
            EXPECT_LT(budget["texture_quality"], 90);
            EXPECT_GT(budget["texture_quality"], 40);
        }
    }
    const Outcome sharp = run_map(folder, "a.glb",
                                  {"--color", sample("left.png"), "--max-bytes", "20000", "--set",
                                   "export.texture_quality=90", "--verbose"});
    EXPECT_LE(sharp.bytes, 20000u);
    EXPECT_EQ(texture_of(sharp)[0], 90) << "as given";
    EXPECT_GT(texture_of(sharp)[1], 0);
    EXPECT_CONTAINS(sharp.process.err, "budget: texture of quality 90, at most ");
    run_map(folder, "a.glb",  // whose texture alone is larger
            {"--color", sample("left.png"), "--max-bytes", "9000", "--set", "export.texture_quality=90",
             "--set", "export.texture_max_px=320"},
            2);
}

// A budget chooses the preset `compact` if no preset is named; explicit settings are kept.
TEST(Budget, ChoosesTheCompactPreset) {
    const TemporaryFolder folder;
    const auto config = [&](const std::vector<std::string>& extra) {
        const Outcome o = run_map(folder, "a.glb", extra);
        Json found = o.report["config"];
        for (const char* section : {"input", "budget", "run"}) found.erase(section);
        found["mesh"].erase("spacing_px");
        found["export"].erase("tolerance_px");
        return found;
    };
    const Json compact = config({"--config", "compact"}), plain = config({});
    ASSERT_NE(compact, plain);
    EXPECT_EQ(config({"--max-bytes", "9000"}), compact);
    EXPECT_EQ(config({"--set", "budget.max_bytes=9000"}), compact);
    EXPECT_EQ(config({"--max-bytes", "30000", "--config", "default"}), plain);
    EXPECT_EQ(config({"--max-error-px", "2"}), plain);
    const Json vertices = config({"--vertices", "900"});
    EXPECT_EQ(vertices["density"], compact["density"]);
    EXPECT_EQ(vertices["mesh"], compact["mesh"]);
    EXPECT_EQ(vertices["surface"], compact["surface"]);
    EXPECT_EQ(vertices["export"], plain["export"]);
    const Json set =
        config({"--max-bytes", "30000", "--set", "density.exponent=3", "--set", "export.compression=none"});
    EXPECT_EQ(set["density"]["exponent"], 3);
    EXPECT_EQ(set["export"]["compression"], "none");
    EXPECT_EQ(set["surface"], compact["surface"]);
}

TEST(Budget, ErrorIsKept) {
    const TemporaryFolder folder;
    std::size_t finer = 0;
    for (const double limit : {0.3, 0.7}) {
        const Outcome o = run_map(folder, "a.obj", {"--max-error-px", std::to_string(limit)});
        EXPECT_LE(o.report["surface"]["duo_rmse_near_px"], limit);
        EXPECT_NEAR(o.report["budget"]["reached"].get<double>(),
                    o.report["surface"]["duo_rmse_near_px"].get<double>(), 1e-9)
            << "nothing is compressed";
        const std::size_t vertices = o.report["surface"]["vertices"];
        if (finer > 0) {
            EXPECT_LT(vertices, finer);
        }
        finer = vertices;
    }
}

// Expects that a run with the spacing and the tolerance found makes the same a.drc.
void expect_again_without_budget(const TemporaryFolder& folder, const Outcome& found) {
    const std::string bytes = read_text(folder / "a.drc");
    const Json& config = found.report["config"];
    const Outcome plain =
        run_map(folder, "a.drc",
                {"--config", "compact", "--set", "mesh.spacing_px=" + config["mesh"]["spacing_px"].dump(),
                 "--set", "export.tolerance_px=" + config["export"]["tolerance_px"].dump()});
    EXPECT_EQ(read_text(folder / "a.drc"), bytes);
    EXPECT_TRUE(plain.report["budget"].is_null());
}

// The configuration in the report gives the same bytes again, without the search.
TEST(Budget, TheSpacingFoundMakesTheSameFile) {
    const TemporaryFolder folder;
    const Outcome found = run_map(folder, "a.drc", {"--max-bytes", "6000"});
    const std::string bytes = read_text(folder / "a.drc");
    const Outcome again = run_map(folder, "a.drc", {"--max-bytes", "6000", "--threads", "3"});
    EXPECT_EQ(read_text(folder / "a.drc"), bytes) << "deterministic";
    expect_again_without_budget(folder, found);
}

// With export.tolerance_share the tolerance follows the surface's accuracy, and is
// never coarser than tolerance_px.
TEST(Tolerance, FollowsTheSurfacesOwnError) {
    const TemporaryFolder folder;
    const auto tolerance = [&](const std::string& share, const std::string& most) {
        const Outcome o =
            run_map(folder, "a.drc",
                    {"--set", "export.tolerance_share=" + share, "--set", "export.tolerance_px=" + most});
        // The surface has the same error in every file; only the report of the .obj shows it.
        const Outcome exact = run_map(folder, "exact.obj", {});
        return std::pair{o.report["config"]["export"]["tolerance_px"].get<double>(),
                         exact.report["surface"]["flat_rmse_px"].get<double>()};
    };
    const auto [whole, error_px] = tolerance("1", "5");
    ASSERT_GT(error_px, 0.02);
    ASSERT_LT(error_px, 2);
    EXPECT_NEAR(whole, error_px, 1e-3);
    const std::uintmax_t fine = std::filesystem::file_size(folder / "a.drc");
    EXPECT_NEAR(tolerance("2", "5").first, 2 * error_px, 1e-3);
    EXPECT_LT(std::filesystem::file_size(folder / "a.drc"), fine);
    EXPECT_DOUBLE_EQ(tolerance("1", "0.015").first, 0.015) << "tolerance_px is the most";
    EXPECT_DOUBLE_EQ(tolerance("0", "5").first, 5);
}

// The tolerance in the report gives the same bytes again.
TEST(Tolerance, HoldsInABudget) {
    const TemporaryFolder folder;
    const Outcome found = run_map(folder, "a.drc", {"--config", "compact", "--max-bytes", "5000"});
    EXPECT_LE(found.bytes, 5000u);
    EXPECT_EQ(found.report["budget"]["tolerance_px"], found.report["config"]["export"]["tolerance_px"]);
    expect_again_without_budget(folder, found);
}

TEST(Budget, SaysInOneLineWhatIsOutOfReach) {
    const TemporaryFolder folder;
    for (const std::vector<std::string>& extra :
         {std::vector<std::string>{"--max-bytes", "60"}, {"--vertices", "3"}, {"--max-error-px", "0.0001"}}) {
        const Outcome o = run_map(folder, "a.drc", extra, 2);
        EXPECT_CONTAINS(o.process.err, "out of reach");
        EXPECT_EQ(std::count(o.process.err.begin(), o.process.err.end(), '\n'), 1) << o.process.err;
        EXPECT_FALSE(std::filesystem::exists(folder / "a.drc"));
    }
    const Outcome both = run_map(folder, "a.drc", {"--max-bytes", "6000", "--vertices", "300"}, 2);
    EXPECT_CONTAINS(both.process.err, "exclude each other");
}

// Writes a map of a slope with a building, beside which something is hidden.
void write_slope(const std::string& path) {
    constexpr int width = 150, height = 110;
    std::vector<float> values;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            values.push_back(30.0f + 0.1f * static_cast<float>(x + 2 * y) +
                             (x < 40 && y < 30 ? 25.0f : 0.0f));
    exporters::write_pfm(path, width, height, values);
}

// The coarsest spacing at which three levels fit is no whole number of hundredths.
TEST(Budget, LevelsOfDetailLimitTheSpacing) {
    const TemporaryFolder folder;
    write_slope(folder / "l.pfm");
    expect_success({"run", "--disparity", folder / "l.pfm", "--set", "export.lod=3", "--max-bytes", "38000",
                    "-o", folder / "f.obj", "--quiet"});
}

TEST(Budget, WhatTheLeftCameraDoesNotSeeGivesWay) {
    const TemporaryFolder folder;
    write_slope(folder / "l.pfm");
    const auto result =
        expect_success({"run", "--disparity", folder / "l.pfm", "--set", "export.lod=3", "--max-bytes",
                        "30000", "--report", folder / "r.json", "-o", folder / "f.obj"});
    EXPECT_CONTAINS(result.err, "(surface.views=left)");
    EXPECT_CONTAINS(read_text(folder / "r.json"), "\"hidden_triangles\": 0");
}

}  // namespace
}  // namespace hexrelief::job
