#include "pipeline/tiles/merge_tiles.h"

#include <algorithm>
#include <mutex>
#include <vector>

#include "exporters/tileset/joined_glb.h"
#include "exporters/tileset/tileset.h"
#include "mesher/tiles/coarser_tile.h"
#include "pipeline/data/error.h"
#include "pipeline/files/interrupt.h"
#include "pipeline/stages/surface.h"
#include "pipeline/tiles/solve_tiles.h"
#include "pipeline/tiles/tile_files.h"
#include "pipeline/tiles/tile_output.h"

namespace hexrelief::tiles {
namespace {

namespace fs = std::filesystem;
using SeamEdge = std::array<mesh_tiles::TileCorner, 2>;

constexpr double kShareOfChildren = 0.25;  // share of the children's triangles

void check_solved(const TilePlan& plan, const std::vector<TileNumber>& tiles, int threads) {
    std::vector<char> solved(tiles.size());
    do_jobs(tiles.size(), threads, [&](std::size_t k) { solved[k] = is_solved(plan, tiles[k]); });
    const auto first = std::ranges::find(solved, 0);
    if (first == solved.end()) return;
    const auto others = std::count(first + 1, solved.end(), 0);
    throw Error(ErrorKind::input,
                plan.folder.string() + ": tile " +
                    tile_name(plan, tiles[static_cast<std::size_t>(first - solved.begin())]) +
                    " is not solved" + (others > 0 ? " (and " + std::to_string(others) + " more)" : "") +
                    "; run 'hexrelief tiles solve'");
}

mesh_tiles::TileMesh mesh_of(const TilePlan& plan, const TileNumber& tile) {
    return read_tile(tile_file(plan, tile, ".mesh"));
}

// Checks that each edge between two tiles occurs once in each direction.
void check_seams(const TilePlan& plan, const std::vector<TileNumber>& tiles, int threads) {
    std::vector<SeamEdge> edges;
    std::mutex turn;
    do_jobs(tiles.size(), threads, [&](std::size_t k) {
        const mesh_tiles::TileMesh mesh = mesh_of(plan, tiles[k]);
        const std::lock_guard lock(turn);
        edges.insert(edges.end(), mesh.seam_edges.begin(), mesh.seam_edges.end());
    });
    std::ranges::sort(edges);
    const bool is_whole = std::ranges::adjacent_find(edges) == edges.end() &&
                          std::ranges::all_of(edges, [&](const SeamEdge& edge) {
                              return std::ranges::binary_search(edges, SeamEdge{edge[1], edge[0]});
                          });
    if (!is_whole)
        throw Error(ErrorKind::input,
                    plan.folder.string() + ": neighbouring tiles do not fit; solve them again with --force");
}

// Returns the pixels that the mesh covers, in whole squares of by x by px.
mesh_tiles::MapRect extent_of(const TilePlan& plan, const mesh_tiles::TileMesh& mesh, int by) {
    mesh_tiles::Place least = mesh.corners.front().place, most = least;
    for (const mesh_tiles::TileCorner& c : mesh.corners) {
        least = {std::min(least.x, c.place.x), std::min(least.y, c.place.y)};
        most = {std::max(most.x, c.place.x), std::max(most.y, c.place.y)};
    }
    const auto below = [&](std::int32_t at) {
        return std::max(0, at / mesh_tiles::kPlacesPerPixel / by * by);
    };
    const auto above = [&](std::int32_t at, int size) {
        return std::min(size, (at / mesh_tiles::kPlacesPerPixel / by + 1) * by);
    };
    const int x = below(least.x), y = below(least.y);
    return {x, y, above(most.x, plan.width) - x, above(most.y, plan.height) - y};
}

void solve_coarser(const TilePlan& plan, const TileNumber& tile,
                   const std::vector<mesh_tiles::TileMesh>& parts, const readers::PictureWindows* picture,
                   int threads) {
    std::vector<mesh_tiles::TileMesh> children;
    for (const TileNumber& child : children_of(plan, tile)) children.push_back(mesh_of(plan, child));
    const Calibration& camera = plan.calibration;
    const mesh_tiles::CoarserTile coarser = mesh_tiles::coarser_tile(
        children, parts, kShareOfChildren,
        [&](double disparity) { return -stages::position_in_space(0, 0, disparity, camera)[2]; });
    TileReport report;
    report.error_px = coarser.error_px;
    report.error_m = coarser.error_m;
    if (coarser.mesh.empty()) {
        write_tile(plan, tile, coarser.mesh, {}, nullptr, threads, report);
        return;
    }
    const int by = 1 << (plan.finest_level() - tile.level);
    const mesh_tiles::MapRect extent = extent_of(plan, coarser.mesh, by);
    Image texture;
    if (picture) texture = picture->read_shrunk(extent.x, extent.y, extent.width, extent.height, by);
    write_tile(plan, tile, coarser.mesh, tile_scene(plan, coarser.mesh, extent),
               texture.empty() ? nullptr : &texture, threads, report);
}

// A job: a tile is simplified by itself, or a coarser tile is joined from the results of other jobs.
struct LevelJob {
    TileNumber tile;
    // Jobs whose results are joined; empty: the tile is simplified by itself.
    std::vector<std::size_t> parts = {};
};

struct LevelJobs {
    std::vector<LevelJob> jobs;
    std::vector<std::size_t> needed_by;  // as for do_jobs_in_turn()

    std::size_t add(const LevelJob& job) {
        jobs.push_back(job);
        needed_by.push_back(kNeededByNone);
        return jobs.size() - 1;
    }
};

// Adds the jobs for `tile` and for the coarser tiles within it that are missing. Returns the last job, that
// of `tile` itself; kNeededByNone if the tile exists.
std::size_t add_missing(const TilePlan& plan, const TileNumber& tile, LevelJobs& all) {
    if (tile.level == plan.finest_level()) return kNeededByNone;
    const bool is_there = is_solved(plan, tile);
    LevelJob whole{tile};
    for (const TileNumber& child : children_of(plan, tile)) {
        const std::size_t made = add_missing(plan, child, all);
        if (is_there) continue;
        whole.parts.push_back(all.add({child}));
        if (made != kNeededByNone) all.needed_by[made] = whole.parts.back();
    }
    if (is_there) return kNeededByNone;
    const std::size_t last = all.add(whole);
    for (const std::size_t part : whole.parts) all.needed_by[part] = last;
    return last;
}

void solve_coarser_levels(const TilePlan& plan, int threads, job::RunLog& log) {
    const std::unique_ptr<readers::PictureWindows> picture =
        plan.color.path.empty() ? nullptr : readers::PictureWindows::open(plan.color.path);
    LevelJobs all;
    add_missing(plan, {0, 0, 0}, all);
    std::vector<mesh_tiles::TileMesh> simplified(all.jobs.size());
    std::mutex turn;
    double done = 0;
    do_jobs_in_turn(all.needed_by, threads, [&](std::size_t k) {
        files::wait_if_interrupted();
        const LevelJob& job = all.jobs[k];
        if (job.parts.empty()) {
            simplified[k] = mesh_tiles::simplified_alone(mesh_of(plan, job.tile), kShareOfChildren);
        } else {
            std::vector<mesh_tiles::TileMesh> parts;
            for (const std::size_t part : job.parts) parts.push_back(std::move(simplified[part]));
            const auto beside = static_cast<int>(tiles_of_level(plan, job.tile.level).size());
            solve_coarser(plan, job.tile, parts, picture.get(), std::max(1, threads / beside));
        }
        const std::lock_guard lock(turn);
        log.progress(++done / static_cast<double>(all.jobs.size()));
    });
}

// Returns the tiles that are not empty, and the root. The error of a coarser tile is added to those of
// the tiles in it.
std::vector<tileset::TilesetTile> tileset_tiles(const TilePlan& plan) {
    std::vector<tileset::TilesetTile> tiles;
    std::vector<tileset::TilesetTile> below;
    for (int level = plan.finest_level(); level >= 0; --level) {
        std::vector<tileset::TilesetTile> here;
        for (const TileNumber& number : tiles_of_level(plan, level)) {
            const TileReport report = read_tile_report(tile_file(plan, number, ".json"));
            if (report.triangles == 0 && level > 0) continue;
            tileset::TilesetTile tile{
                level, number.i, number.j, report.low_m, report.high_m, 0, report.triangles > 0};
            for (const tileset::TilesetTile& child : below)
                if (child.x / 2 == tile.x && child.y / 2 == tile.y)
                    tile.error_m = std::max(tile.error_m, child.error_m + report.error_m);
            here.push_back(tile);
        }
        tiles.insert(tiles.end(), here.begin(), here.end());
        below = std::move(here);
    }
    return tiles;
}

void write_tileset(const TilePlan& plan, const fs::path& output, files::OutputSet& files) {
    const std::string generator = std::string("hexrelief ") + HEXRELIEF_VERSION;
    const fs::path folder = output.parent_path();
    const fs::path content =
        fs::absolute(plan.folder / "tiles")
            .lexically_normal()
            .lexically_relative(fs::absolute(folder.empty() ? "." : folder).lexically_normal()) /
        "{level}/{x}/{y}.glb";
    const std::vector<tileset::TilesetTile> tiles = tileset_tiles(plan);
    const tileset::ImplicitTileset halved =
        tileset::implicit_tileset(tiles, content.generic_string(), generator);
    for (const auto& subtree : halved.subtrees) files.write(folder / subtree.name, subtree.bytes);
    files.write(fs::path(output).replace_extension(".implicit.json"), halved.json);
    files.write(output, tileset::explicit_tileset(tiles, content.generic_string(), generator));
}

// Refuses an output that would overwrite the tiles or their sources.
void check_output(const TilePlan& plan, const fs::path& output) {
    const std::string ending = output.extension().string();
    if (ending != ".json" && ending != ".glb")
        throw Error(ErrorKind::usage, "'" + output.string() + "': tiles are merged into .json or .glb");
    std::vector<fs::path> read = {plan_file(plan.folder), plan.map.path, plan.color.path};
    for (const auto& [name, sum] : plan.sums) read.push_back(plan.folder / name);
    files::check_overwrites({output}, read);
    const fs::path tiles = fs::weakly_canonical(plan.folder / "tiles"), at = files::identify(output).path;
    if (std::mismatch(tiles.begin(), tiles.end(), at.begin(), at.end()).first == tiles.end())
        throw Error(ErrorKind::usage, output.string() + " would be among the tiles; choose another folder");
}

}  // namespace

MergedTiles merge_tiles(const TilePlan& plan, const fs::path& output, int threads, job::RunLog& log) {
    check_output(plan, output);
    keep_freed_memory();
    const std::vector<TileNumber> tiles = tiles_of_level(plan, plan.finest_level());
    log.stage("check", [&] {
        check_solved(plan, tiles, threads);
        check_seams(plan, tiles, threads);
    });
    MergedTiles merged{tiles.size(), 0, 0, 0, 1};
    std::vector<fs::path> contents;
    for (const TileNumber& tile : tiles) {
        const TileReport report = read_tile_report(tile_file(plan, tile, ".json"));
        merged.vertices += report.vertices;
        merged.triangles += report.triangles;
        merged.empty += report.triangles == 0;
        if (report.triangles > 0) contents.push_back(tile_file(plan, tile, ".glb"));
    }
    if (merged.empty == merged.tiles)
        throw Error(ErrorKind::input, plan.folder.string() + ": nothing is in any of the tiles");
    files::OutputSet files;
    if (output.extension() == ".json") {
        merged.levels = plan.finest_level() + 1;
        log.stage("levels", [&] { solve_coarser_levels(plan, threads, log); });
        log.stage("tileset", [&] { write_tileset(plan, output, files); });
    } else {
        files.place(output);
        log.stage("join", [&] {
            tileset::join_glb(contents, std::string("hexrelief ") + HEXRELIEF_VERSION, output, files.files());
        });
    }
    files.commit();
    return merged;
}

}  // namespace hexrelief::tiles
