// Tests plan, solve and merge: data shared by neighbours is identical to the bit in every format and
// level, whatever solves it.
#include <gtest/gtest.h>

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "exporters/images/image_writer.h"
#include "pipeline/data/error.h"
#include "pipeline/files/output_set.h"
#include "pipeline/files/sha256.h"
#include "pipeline/readers/image_reader.h"
#include "pipeline/readers/windows/map_writer.h"
#include "pipeline/stages/surface.h"
#include "pipeline/tiles/make_plan.h"
#include "pipeline/tiles/merge_tiles.h"
#include "pipeline/tiles/planned_map.h"
#include "pipeline/tiles/solve_tiles.h"
#include "pipeline/tiles/tile_files.h"
#include "pipeline/tiles/tile_output.h"
#include "tests/mesher/busy_map.h"
#include "tests/pipeline/process.h"
#include "tests/pipeline/tiles/glb_reading.h"

namespace hexrelief::tiles {
namespace {

using namespace test;
using namespace testing_mesher;

using testing_mesher::busy_map;
using testing_mesher::busy_picture;
using Point = std::array<double, 3>;

constexpr int kWidth_px = 372, kHeight_px = 290, kTile = 78;  // 2 x 1 tiles, or 2 x 2 with kRows
constexpr int kTall_px = 372;

void write_map(const std::string& path, const DisparityMap& map) {
    files::OutputSet files;
    files.place(path);
    readers::MapWriter writer(files.files(), path, map.width, map.height, 64);
    writer.write(map.values.data(), map.height);
    writer.finish();
    files.commit();
}

config::Config small_config(exporters::Compression compression) {
    config::Config config;
    config.mesh.spacing_px = 3;
    config.exporting.compression = compression;
    config.input.calibration.focal_px = 400;
    config.input.calibration.baseline_m = 0.1;
    return config;
}

job::BackendPointer cpu(int threads) {
    return job::pick_backend(config::BackendChoice::cpu, threads);
}

class PlannedFolder {
  public:
    explicit PlannedFolder(const DisparityMap& map,
                           exporters::Compression compression = exporters::Compression::none,
                           bool with_picture = false) {
        write_map(folder_ / "map.tif", map);
        PlanRequest request{folder_ / "map.tif", {}, folder_ / "p", {}, kTile, small_config(compression)};
        if (with_picture) {
            exporters::write_png(folder_ / "left.png", busy_picture(map, 1));
            request.color = folder_ / "left.png";
        }
        plan = make_plan(request, *cpu(2), log_);
    }
    std::vector<TileNumber> tiles() const { return tiles_of_level(plan, plan.finest_level()); }
    void solve(const std::vector<TileNumber>& wanted, int threads, int jobs) const {
        solve_tiles(plan, wanted, *cpu(1), {threads, jobs, 0},
                    {[](const TileNumber&, const std::string& failure, int) { EXPECT_EQ(failure, ""); }});
    }
    void solve() const { solve(tiles(), 2, 2); }
    MergedTiles merge(const std::string& name) { return merge_tiles(plan, folder_ / name, 2, log_); }
    std::map<std::string, std::string> sums() const {
        std::map<std::string, std::string> found;
        for (const auto& entry : std::filesystem::recursive_directory_iterator(plan.folder))
            if (entry.is_regular_file())
                found[entry.path().lexically_relative(plan.folder)] = files::sha256_of_file(entry.path());
        return found;
    }
    std::string operator/(const std::string& name) const { return folder_ / name; }

    TilePlan plan;

  private:
    TemporaryFolder folder_;
    job::RunLog log_;
};

Point in_space(const TilePlan& plan, const mesh_tiles::TileCorner& corner) {
    Point p = stages::position_in_space(corner.place.x / 1024.0, corner.place.y / 1024.0, corner.disparity,
                                        plan.calibration);
    for (double& x : p) x = std::round(x / plan.grid_step_m) * plan.grid_step_m;
    return p;
}

class TileFormats : public ::testing::TestWithParam<exporters::Compression> {};

TEST_P(TileFormats, BordersAreTheSameBitsOnEveryLevel) {
    PlannedFolder folder(busy_map(kTall_px, kTall_px, 1), GetParam());
    folder.solve();
    EXPECT_EQ(folder.merge("p/tileset.json").levels, 2);
    const TilePlan& plan = folder.plan;
    std::size_t borders = 0;
    for (int level = 0; level <= plan.finest_level(); ++level)
        for (const TileNumber& tile : tiles_of_level(plan, level)) {
            const mesh_tiles::TileMesh mesh = read_tile(tile_file(plan, tile, ".mesh"));
            const SpaceMesh file = read_glb(tile_file(plan, tile, ".glb"));
            EXPECT_EQ(file.triangles.size(), mesh.triangles.size());
            std::set<Point> expected, found(file.positions.begin(), file.positions.end());
            for (const Triangle& t : mesh.triangles)
                for (const std::uint32_t v : t) expected.insert(in_space(plan, mesh.corners[v]));
            EXPECT_TRUE(found == expected) << tile_name(plan, tile);
            for (const auto& edge : mesh.seam_edges)
                borders += found.contains(in_space(plan, edge[0])) && found.contains(in_space(plan, edge[1]));
        }
    EXPECT_GT(borders, 300u);
}

INSTANTIATE_TEST_SUITE_P(All, TileFormats,
                         ::testing::Values(exporters::Compression::none, exporters::Compression::quantized,
                                           exporters::Compression::meshopt, exporters::Compression::draco));

TEST(Tiles, AreTheSameBytesInAnyOrderAndByAnyNumberOfWorkers) {
    const DisparityMap map = busy_map(kWidth_px, kHeight_px, 2);
    PlannedFolder one(map, exporters::Compression::none, true), many(map, exporters::Compression::none, true);
    one.solve(one.tiles(), 1, 1);
    std::vector<TileNumber> backwards = many.tiles();
    std::reverse(backwards.begin(), backwards.end());
    many.solve(backwards, 3, 2);
    const auto sums = one.sums(), others = many.sums();
    ASSERT_EQ(sums.size(), others.size());
    for (const auto& [name, sum] : sums) {
        if (name.ends_with(".json")) continue;  // names its plan, which names its map
        EXPECT_EQ(sum, others.at(name)) << name;
    }
}

TEST(Tiles, OnlyWhatIsMissingOrDamagedIsSolvedAgain) {
    PlannedFolder folder(busy_map(kTall_px, kTall_px, 3));
    folder.solve();
    const auto sums = folder.sums();
    const std::vector<TileNumber> tiles = folder.tiles();
    ASSERT_EQ(tiles.size(), 4u);
    for (const TileNumber& tile : tiles) EXPECT_TRUE(is_solved(folder.plan, tile));
    std::filesystem::remove(tile_file(folder.plan, tiles[0], ".glb"));
    write_text(tile_file(folder.plan, tiles[1], ".mesh"), "cut");
    write_text(tile_file(folder.plan, tiles[2], ".json"), "{}");
    EXPECT_THROW(folder.merge("p/tileset.json"), Error);
    std::vector<TileNumber> missing;
    for (const TileNumber& tile : tiles)
        if (!is_solved(folder.plan, tile)) missing.push_back(tile);
    EXPECT_EQ(missing, std::vector<TileNumber>(tiles.begin(), tiles.begin() + 3));
    folder.solve(missing, 1, 1);
    EXPECT_EQ(folder.sums(), sums);
}

TEST(Tiles, AsOneGlbHaveTheTrianglesOfAll) {
    for (const exporters::Compression compression :
         {exporters::Compression::none, exporters::Compression::meshopt, exporters::Compression::draco}) {
        PlannedFolder folder(busy_map(kWidth_px, kHeight_px, 1), compression, true);
        folder.solve();
        const MergedTiles merged = folder.merge("scene.glb");
        const SpaceMesh whole = read_glb(folder / "scene.glb");
        EXPECT_EQ(whole.triangles.size(), merged.triangles);
        std::set<Point> found(whole.positions.begin(), whole.positions.end()), expected;
        for (const TileNumber& tile : folder.tiles()) {
            const SpaceMesh part = read_glb(tile_file(folder.plan, tile, ".glb"));
            expected.insert(part.positions.begin(), part.positions.end());
        }
        EXPECT_TRUE(found == expected);
    }
}

TEST(Tiles, OfMapsThatAreMostlyUnknown) {
    DisparityMap map = busy_map(kTall_px, kTall_px, 4);
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x)
            // Only two corners have disparities, so that the lattice still covers the whole map.
            if (std::max(x, y) >= 140 && std::min(x, y) < 230) map.at(x, y) = std::nanf("");
    PlannedFolder folder(map);
    folder.solve();
    const MergedTiles merged = folder.merge("p/tileset.json");
    EXPECT_LT(merged.empty, merged.tiles);
    const auto json = nlohmann::json::parse(read_text(folder / "p/tileset.json"));
    EXPECT_EQ(json["root"]["children"].size(), merged.tiles - merged.empty);
}

TEST(Tiles, WhatIsTransparentInThePictureIsUnknown) {
    const TemporaryFolder folder;
    const Image picture = readers::read_image(sample("inputs/cut_out.png"));
    const DisparityMap map = busy_map(picture.width, picture.height, 1);
    write_map(folder / "map.tif", map);
    const mesh_tiles::MapRect window{10, 5, 60, 50};
    job::RunLog log;
    const auto unknown_pixels = [&](bool alpha) {
        PlanRequest request{folder / "map.tif",
                            sample("inputs/cut_out.png"),
                            folder / "p",
                            {},
                            kTile,
                            small_config(exporters::Compression::none)};
        request.config.input.mask.alpha = alpha;
        const DisparityMap read = PlannedMap(make_plan(request, *cpu(1), log), false).read(window);
        std::vector<std::uint8_t> unknown;
        for (const float d : read.values) unknown.push_back(!DisparityMap::known(d));
        return unknown;
    };
    std::vector<std::uint8_t> in_map, in_either;
    for (int y = window.y; y < window.y + window.height; ++y)
        for (int x = window.x; x < window.x + window.width; ++x) {
            in_map.push_back(!DisparityMap::known(map.at(x, y)));
            const std::size_t i = static_cast<std::size_t>(y) * picture.width + x;
            in_either.push_back(in_map.back() || picture.alpha.at(i) < kOpaque);
        }
    EXPECT_NE(in_either, in_map);
    EXPECT_EQ(unknown_pixels(true), in_either);
    EXPECT_EQ(unknown_pixels(false), in_map);
}

TEST(Tiles, OfSmallMapsAreOneTile) {
    PlannedFolder folder(busy_map(40, 25, 1));
    folder.solve();
    EXPECT_EQ(folder.merge("p/tileset.json").levels, 1);
}

// --- by the command line

std::vector<std::string> plan_words(const TemporaryFolder& folder,
                                    const std::vector<std::string>& more = {}) {
    return test::joined({"tiles", "plan", folder / "map.tif", "-o", folder / "p", "--set",
                         "mesh.spacing_px=3", "--tile-vertices", "78", "--quiet"},
                        more);
}

TEST(TilesByCommand, KilledWorkersLoseNothing) {
    const TemporaryFolder folder;
    write_map(folder / "map.tif", busy_map(kTall_px, kTall_px, 5));
    expect_success(plan_words(folder));
    const std::vector<std::string> solve = {"tiles", "solve", folder / "p", "--quiet"};
    for (int k = 0; k < 6; ++k) {
        const pid_t worker = start_program(solve);
        usleep(static_cast<useconds_t>(20000 + 45000 * k));
        kill(worker, SIGKILL);
        wait_for_exit(worker);
    }
    expect_success(solve);
    expect_success({"tiles", "merge", folder / "p", "-o", folder / "p/tileset.json"});
    const TilePlan plan = read_plan(folder / "p");
    std::map<std::string, std::string> sums;
    for (const TileNumber& tile : tiles_of_level(plan, plan.finest_level()))
        for (const char* ending : {".mesh", ".glb", ".json"})
            sums[tile_file(plan, tile, ending)] = files::sha256_of_file(tile_file(plan, tile, ending));
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder / "p"))
        EXPECT_FALSE(entry.path().filename().string().ends_with(".tmp")) << entry.path();
    expect_success({"tiles", "solve", folder / "p", "--force", "--quiet"});
    for (const auto& [name, sum] : sums) EXPECT_EQ(files::sha256_of_file(name), sum) << name;
}

TEST(TilesByCommand, APlanIsTheSameByAnyThreadsAndBackend) {
    const TemporaryFolder folder;
    write_map(folder / "map.tif", busy_map(kTall_px, kTall_px, 7));
    expect_success(plan_words(folder, {"--threads", "1", "--backend", "cpu"}));
    const std::string plan = read_text(folder / "p/plan.json");
    std::filesystem::remove_all(folder / "p");
    expect_success(plan_words(folder, {"--threads", "3"}));
    EXPECT_EQ(read_text(folder / "p/plan.json"), plan);
}

TEST(TilesByCommand, PresetsThatTheHelpNamesDoForTiles) {
    const TemporaryFolder folder;
    write_map(folder / "map.tif", busy_map(120, 100, 1));
    const std::string help = run_program({"tiles", "plan", "--help"}).out;
    for (const auto& [preset, setting] :
         {std::pair{"compact", "surface.silhouette_rounds=0"}, {"quality", "density.detail=0"}}) {
        const std::vector<std::string> words = {"--set", setting, "--config", preset};
        EXPECT_CONTAINS(help, std::string("--set ") + setting);
        EXPECT_EQ(run_program(plan_words(folder, words)).exit_code, 0) << preset;
    }
}

TEST(TilesByCommand, ShardsAndPrintedCommandsAreAllTiles) {
    const TemporaryFolder folder;
    write_map(folder / "map.tif", busy_map(kTall_px, kTall_px, 6));
    expect_success(plan_words(folder));
    const ProcessResult commands = run_program({"tiles", "solve", folder / "p", "--print-commands"});
    EXPECT_EQ(std::count(commands.out.begin(), commands.out.end(), '\n'), 4);
    EXPECT_CONTAINS(commands.out, "--tile 1,0\n");
    expect_success({"tiles", "solve", folder / "p", "--shard", "1/3"});
    const ProcessResult early = run_program({"tiles", "merge", folder / "p", "-o", folder / "s.glb"});
    EXPECT_EQ(early.exit_code, 3);
    EXPECT_CONTAINS(early.err, "tile (0, 1) is not solved (and 1 more)");
    EXPECT_FALSE(std::filesystem::exists(folder / "s.glb"));
    expect_success({"tiles", "solve", folder / "p", "--shard", "2/3"});
    expect_success({"tiles", "solve", folder / "p", "--tile", "1,0"});
    expect_success({"tiles", "merge", folder / "p", "-o", folder / "s.glb"});
}

void expect_refused(const ProcessResult& result, int exit_code, const std::string& why) {
    EXPECT_EQ(result.exit_code, exit_code) << result.err;
    EXPECT_CONTAINS(result.err, why);
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
}

TEST(TilesByCommand, MistakesAreOneLine) {
    const TemporaryFolder folder;
    const std::string map = folder / "map.tif";
    expect_refused(run_program(plan_words(folder)), 3, "map.tif");
    DisparityMap unknown{60, 60, std::vector<float>(3600, kUnknownDisparity)};
    write_map(map, unknown);
    const std::vector<std::string> camera = {"--set", "input.calibration.focal_px=50", "--set",
                                             "input.calibration.baseline_m=1"};
    expect_refused(run_program(plan_words(folder, camera)), 3, "nothing is left to mesh");
    EXPECT_FALSE(std::filesystem::exists(folder / "p"));
    write_map(map, busy_map(120, 100, 1));
    for (const char* setting :
         {"density.detail=0.5", "mesh.border=free", "surface.silhouette_rounds=1", "export.lod=2"}) {
        expect_refused(run_program(plan_words(folder, camera), {"--set", setting}), 2,
                       std::string(setting).substr(0, std::string(setting).find('=')));
    }
    expect_refused(run_program(plan_words(folder, {"--threads", "1025"})), 2, "an integer from 0 to 1024");
    expect_refused(run_program({"tiles", "plan", map, "-o", folder / "p", "--tile-vertices", "77"}), 2,
                   "not in range 78 to ");
    expect_refused(run_program({"tiles", "solve", folder / "p"}), 3, "plan.json");
    expect_success(plan_words(folder, camera));
    expect_refused(run_program({"tiles", "solve", folder / "p", "--tile", "4,4"}), 2, "--tile");
    expect_refused(run_program({"tiles", "merge", folder / "p", "-o", folder / "p/a.obj"}), 2, "a.obj");
    expect_refused(run_program({"tiles", "merge", folder / "p", "-o", folder / "p/plan.json"}), 2,
                   "overwrite the input");
    expect_refused(run_program({"tiles", "merge", folder / "p", "-o", folder / "p/tiles/0/a.json"}), 2,
                   "among the tiles");
    write_text(folder / "p/coarse.lattice", "no lattice");
    expect_refused(run_program({"tiles", "solve", folder / "p"}), 3, "coarse.lattice");
    write_map(map, busy_map(120, 100, 2));
    expect_refused(run_program({"tiles", "solve", folder / "p"}), 3, "has changed since the plan");
    write_text(folder / "p/plan.json", "{");
    expect_refused(run_program({"tiles", "solve", folder / "p"}), 3, "plan.json: damaged");
}

TEST(Tiles, APlanWhoseNumbersDoNotAgreeIsRefused) {
    const PlannedFolder tiled(busy_map(kWidth_px, kHeight_px, 2));
    const std::filesystem::path file = plan_file(tiled.plan.folder);
    const std::string plan = read_text(file);
    const auto error_with = [&](const std::string& key, const std::string& value) {
        std::string text = plan;
        const std::size_t at = text.find("\"" + key + "\": ") + key.size() + 4;
        write_text(file, text.replace(at, text.find_first_of(",\n", at) - at, value));
        return test::refusal_of([&] { read_plan(tiled.plan.folder); });
    };
    for (const char* const key : {"rows", "columns", "tile_spacings", "shrunk_by", "width", "height"})
        for (const char* const value : {"0", "-1", "4294967296", "1e9", "\"x\"", "2000001"})
            EXPECT_CONTAINS(error_with(key, value), "damaged") << key << value;
    EXPECT_CONTAINS(error_with("grid_step_m", "0"), "do not agree");
    EXPECT_CONTAINS(error_with("focal_px", "-1"), "do not agree");
    EXPECT_CONTAINS(error_with("plan", std::string(100000, '[')), "damaged");
}

TEST(Tiles, APipeAmongThemIsNotWaitedFor) {
    const PlannedFolder tiled(busy_map(kWidth_px, kHeight_px, 2));
    const std::filesystem::path tile = tile_file(tiled.plan, tiled.tiles().front(), ".mesh");
    std::filesystem::create_directories(tile.parent_path());
    ASSERT_EQ(mkfifo(tile.c_str(), 0600), 0);
    std::string failed;
    solve_tiles(tiled.plan, {tiled.tiles().front()}, *cpu(1), {1, 1, 0},
                {[&](const TileNumber&, const std::string& failure, int) { failed = failure; }});
    EXPECT_CONTAINS(failed, "is no regular file");
}

}  // namespace
}  // namespace hexrelief::tiles
