
#include <cstdio>
#include <functional>
#include <memory>

#include "pipeline/cli/arguments/argument_parser.h"
#include "pipeline/cli/commands.h"
#include "pipeline/cli/printable.h"
#include "pipeline/cli/run_options.h"
#include "pipeline/data/number_text.h"
#include "pipeline/files/interrupt.h"
#include "pipeline/files/output_set.h"
#include "pipeline/job/backend.h"
#include "pipeline/job/log/run_log.h"
#include "pipeline/library/conversions.h"
#include "pipeline/tiles/make_plan.h"
#include "pipeline/tiles/matching/match_in_tiles.h"
#include "pipeline/tiles/merge_tiles.h"

namespace hexrelief::cli {
namespace {

struct Loudness {
    bool quiet = false, verbose = false;
};

void add_loudness(Command& command, Loudness& loudness, const std::string& verbose_help) {
    command.add_flag("--quiet", loudness.quiet, "nothing but errors");
    command.add_flag("--verbose", loudness.verbose, verbose_help);
}

// Does work whose progress the terminal shows, and prints the line that it returns, with the seconds.
int tell(const Loudness& loudness, const std::function<std::string(job::RunLog& log)>& work) {
    files::install_interrupt_handling();
    ProgressLine progress;
    job::RunLog log;
    library::tell_caller(told_on_terminal({},
                                          loudness.quiet     ? Verbosity::quiet
                                          : loudness.verbose ? Verbosity::verbose
                                                             : Verbosity::summary,
                                          progress),
                         log);
    const std::string line = work(log);
    if (!loudness.quiet) std::printf("%s; %s s\n", printable(line).c_str(), fixed(log.seconds(), 1).c_str());
    end_telling();
    return 0;
}

// Does work by the backend that a configuration names, and gives the device back.
template <typename Work>
auto with_backend(const config::ExecutionConfig& config, const Work& work) {
    const int threads = job::effective_threads(config.threads);
    const job::BackendPointer backend = job::Backends::for_one_run().get(config.backend, threads);
    auto result = work(*backend);
    backend->give_back();
    return result;
}

struct PlanOptions {
    std::filesystem::path map, color, folder;
    Options config;
    std::string raw;
    int tile_vertices = 512;
    Loudness loudness;
};

int plan_tiles(const PlanOptions& options) {
    tiles::PlanRequest request{
        options.map, options.color,         options.folder,
        {},          options.tile_vertices, library::config_of(options.config, {}, {"--disparity"})};
    if (!options.raw.empty()) request.raw = readers::parse_raw_map_layout(options.raw);
    files::check_writable_folder(options.folder);
    std::vector<std::filesystem::path> read(options.config.config.begin(), options.config.config.end());
    read.insert(read.end(), {options.map, options.color, request.config.input.calibration.file});
    files::check_overwrites({tiles::plan_file(options.folder), tiles::plan_config_file(options.folder)},
                            read);
    return tell(options.loudness, [&](job::RunLog& log) {
        const tiles::TilePlan plan = with_backend(request.config.run, [&](job::Backend& backend) {
            return tiles::make_plan(request, backend, log);
        });
        return options.folder.string() + ": " +
               size_text(plan.tiling().across(), plan.tiling().down(), " x ") + " tiles, a lattice of " +
               size_text(plan.columns, plan.rows, " x ") + " vertices";
    });
}

struct MatchOptions {
    std::filesystem::path left, right, output;
    Options config;
    int tile_px = tiles::MatchRequest().tile_px;
    Loudness loudness;
};

int match_tiles(const MatchOptions& options) {
    tiles::MatchRequest request{.left = options.left,
                                .right = options.right,
                                .map = options.output,
                                .tile_px = options.tile_px,
                                .config = library::config_of(options.config, {}, {"--left", "--right"})};
    files::check_writable_file(options.output);
    return tell(options.loudness, [&](job::RunLog& log) {
        const tiles::TiledMatch match = with_backend(request.config.run, [&](job::Backend& backend) {
            return tiles::match_in_tiles(request, backend, log);
        });
        return options.output.string() + ": " + size_text(match.width, match.height) + " px in " +
               std::to_string(match.tiles) + " tiles, " + fixed(100 * match.matched_share, 1) +
               " % matched, " + fixed(100 * match.known_share, 1) + " % known";
    });
}

struct MergeOptions {
    std::filesystem::path folder, output;
    int threads = 0;
    Loudness loudness;
};

int merge(const MergeOptions& options) {
    const tiles::TilePlan plan = tiles::read_plan(options.folder);
    files::check_writable_file(options.output);
    return tell(options.loudness, [&](job::RunLog& log) {
        const tiles::MergedTiles merged =
            tiles::merge_tiles(plan, options.output, job::effective_threads(options.threads), log);
        return options.output.string() + ": " + std::to_string(merged.tiles) + " tiles, " +
               std::to_string(merged.empty) + " of them empty, in " + std::to_string(merged.levels) +
               " levels; " + std::to_string(merged.vertices) + " vertices, " +
               std::to_string(merged.triangles) + " triangles";
    });
}

void add_plan_command(Command& group) {
    Command command =
        group.add_command("plan", "the coarse lattice of a map, and the seams between its tiles");
    const auto options = std::make_shared<PlanOptions>();
    command.add_option("map", &options->map, "disparity map: TIFF or BigTIFF, PFM, or raw samples",
                       {.value = "MAP", .required = true});
    command.add_option("-o,--output", &options->folder, "folder of the plan and its tiles",
                       {.value = "DIR", .required = true});
    command.add_option(
        "--tile-vertices", &options->tile_vertices,
        "vertices along a tile's side, rounded to a multiple of 6",
        {.value = "N", .shows_default = true, .range = {{mesh_tiles::LatticeTiling::kLeastTile, 1000000}}});
    command.add_option("--color", &options->color, "the left image, of the map's size, for the texture",
                       {.value = "L"});
    command.add_option("--raw", &options->raw, "the map is samples alone: as 32768x32768,float32",
                       {.value = "WxH,TYPE"});
    add_config_options(command, options->config, "Options");
    add_key_options(
        command, options->config,
        {"--disparity-scale", "--disparity-offset", "--unknown", "--calib", "--backend", "--threads"},
        "Options");
    add_loudness(command, options->loudness, "the stages' times");
    command.set_footer(
        R"(The lattice of the whole map is solved at half of its size, and what lies beside the borders of the
tiles on the map itself. Each tile is then solved by itself, by 'hexrelief tiles solve DIR', and all
fit together to the bit. The map, and the picture, must stay as they are until then.

Of the presets compact needs --set surface.silhouette_rounds=0 beside it, quality needs
--set density.detail=0, and paper and som, which do not balance, are none for tiles.

Example:
  hexrelief tiles plan map.tif -o relief --set export.compression=draco)");
    command.set_action([options] { return plan_tiles(*options); });
}

constexpr const char* kMatchFooter =
    R"(Each tile is matched with the pixels around it, as 'hexrelief run' matches a pair. Of TIFF, BigTIFF,
PGM and PPM no more is read than a tile needs; other pictures are held as a whole. The map is of
32-bit floats in px, unknown where nothing matches. The camera's ndisp, if its file has one, is the
range that is searched.

Example:
  hexrelief tiles match left.tif right.tif -o map.tif --set disparity.num_disparities_px=256
  hexrelief tiles plan map.tif -o relief --color left.tif)";

void add_match_command(Command& group) {
    Command command = group.add_command("match", "a rectified pair of any size to its disparity map");
    const auto options = std::make_shared<MatchOptions>();
    command.add_option("left", &options->left, "the left picture", {.value = "LEFT", .required = true});
    command.add_option("right", &options->right, "the right picture", {.value = "RIGHT", .required = true});
    command.add_option("-o,--output", &options->output, "map.tif (BigTIFF in tiles) or map.pfm",
                       {.value = "MAP", .required = true});
    command.add_option("--tile", &options->tile_px, "a tile's side",
                       {.value = "PX", .shows_default = true, .range = {{64, 16384}}});
    add_config_options(command, options->config, "Options");
    add_key_options(command, options->config, {"--calib", "--backend", "--threads"}, "Options");
    add_loudness(command, options->loudness, "the range searched, and the stages' times");
    command.set_footer(kMatchFooter);
    command.set_action([options] { return match_tiles(*options); });
}

constexpr const char* kMergeFooter =
    R"(Beside FILE.json is FILE.implicit.json, the same tileset by implicit tiling, with its subtrees/. Both
show the GLB files below DIR, which must keep its place beside them. Every edge between two tiles is
looked up in both first.

Example:
  hexrelief tiles merge relief -o relief/tileset.json)";

void add_merge_command(Command& group) {
    Command command =
        group.add_command("merge", "solved tiles to 3D Tiles with levels of detail, or to one GLB");
    const auto options = std::make_shared<MergeOptions>();
    command.add_option("folder", &options->folder, "of 'hexrelief tiles plan'",
                       {.value = "DIR", .required = true});
    command.add_option("-o,--output", &options->output, "tileset.json (3D Tiles 1.1), or scene.glb",
                       {.value = "FILE", .required = true});
    command.add_option("--threads", &options->threads, "CPU threads; 0 = all",
                       {.shows_default = true, .range = {{0, 1024}}});
    add_loudness(command, options->loudness, "the stages' times");
    command.set_footer(kMergeFooter);
    command.set_action([options] { return merge(*options); });
}

}  // namespace

void add_tiles_command(Command& program) {
    Command group =
        program.add_command("tiles", "maps that do not fit into memory, on any number of machines");
    group.set_footer(R"(Example:
  hexrelief tiles plan map.tif -o relief
  hexrelief tiles solve relief
  hexrelief tiles merge relief -o relief/tileset.json)");
    add_match_command(group);
    add_plan_command(group);
    add_solve_command(group);
    add_merge_command(group);
}

}  // namespace hexrelief::cli
