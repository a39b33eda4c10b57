#include "pipeline/cli/tiles/command_tiles.h"

#include <unistd.h>

#include <cstdio>
#include <memory>

#include "pipeline/cli/arguments/config_options.h"
#include "pipeline/cli/terminal/printable.h"
#include "pipeline/data/error.h"
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

// Prints to stderr: if verbose, a line per stage with its time, else the progress on a terminal; and
// warnings. Prints no progress and no warnings if quiet.
class StageTeller {
  public:
    StageTeller(bool quiet, bool verbose) : progress_(!quiet && !verbose && isatty(STDERR_FILENO)) {
        log_.stage_begins = [this](const std::string& stage) { progress_.begin(stage); };
        log_.stage_progresses = [this](double share) { progress_.update(share); };
        log_.stage_ends = [this, verbose](const std::string& stage, double seconds) {
            progress_.end();
            if (verbose) std::fprintf(stderr, "%-14s %8.3f s\n", stage.c_str(), seconds);
        };
        if (verbose)
            log_.decides = [](const std::string& decision) {
                std::fprintf(stderr, "%s\n", printable(decision).c_str());
            };
        if (!quiet)
            log_.warns = [this](const std::string& warning) {
                progress_.break_line();
                print_warning(warning);
            };
    }
    StageTeller(const StageTeller&) = delete;
    StageTeller& operator=(const StageTeller&) = delete;

    job::RunLog& log() { return log_; }

  private:
    ProgressLine progress_;
    job::RunLog log_;
};

struct PlanOptions {
    std::filesystem::path map, color, folder;
    Options config;
    std::string raw;
    int tile_vertices = 512;
    bool quiet = false, verbose = false;
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
    const int threads = job::effective_threads(request.config.run.threads);
    const job::BackendPointer backend = job::Backends::for_one_run().get(request.config.run.backend, threads);
    files::install_interrupt_handling();

    StageTeller teller(options.quiet, options.verbose);
    job::RunLog& log = teller.log();
    const tiles::TilePlan plan = tiles::make_plan(request, *backend, log);
    backend->give_back();
    if (options.quiet) return 0;
    const mesh_tiles::LatticeTiling tiling = plan.tiling();
    std::printf("%s: %d x %d tiles, a lattice of %d x %d vertices; %.1f s\n",
                printable(options.folder.string()).c_str(), tiling.across(), tiling.down(), plan.columns,
                plan.rows, log.seconds());
    end_telling();
    return 0;
}

struct MatchOptions {
    std::filesystem::path left, right, output;
    Options config;
    int tile_px = tiles::MatchRequest().tile_px;
    bool quiet = false, verbose = false;
};

int match_tiles(const MatchOptions& options) {
    tiles::MatchRequest request{.left = options.left,
                                .right = options.right,
                                .map = options.output,
                                .tile_px = options.tile_px,
                                .config = library::config_of(options.config, {}, {"--left", "--right"})};
    files::check_writable_file(options.output);
    const int threads = job::effective_threads(request.config.run.threads);
    const job::BackendPointer backend = job::Backends::for_one_run().get(request.config.run.backend, threads);
    files::install_interrupt_handling();

    StageTeller teller(options.quiet, options.verbose);
    job::RunLog& log = teller.log();
    const tiles::TiledMatch match = tiles::match_in_tiles(request, *backend, log);
    backend->give_back();
    if (!options.quiet)
        std::printf("%s: %dx%d px in %d tiles, %.1f %% matched, %.1f %% known; %.1f s\n",
                    printable(options.output.string()).c_str(), match.width, match.height, match.tiles,
                    100 * match.matched_share, 100 * match.known_share, log.seconds());
    end_telling();
    return 0;
}

struct MergeOptions {
    std::filesystem::path folder, output;
    int threads = 0;
    bool quiet = false, verbose = false;
};

int merge(const MergeOptions& options) {
    const tiles::TilePlan plan = tiles::read_plan(options.folder);
    files::check_writable_file(options.output);
    const int threads = job::effective_threads(options.threads);
    files::install_interrupt_handling();
    StageTeller teller(options.quiet, options.verbose);
    job::RunLog& log = teller.log();
    const tiles::MergedTiles merged = tiles::merge_tiles(plan, options.output, threads, log);
    if (!options.quiet)
        std::printf("%s: %zu tiles, %zu of them empty, in %d levels; %zu vertices, %zu triangles; %.1f s\n",
                    printable(options.output.string()).c_str(), merged.tiles, merged.empty, merged.levels,
                    merged.vertices, merged.triangles, log.seconds());
    end_telling();
    return 0;
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
    command.add_flag("--quiet", options->quiet, "nothing but errors");
    command.add_flag("--verbose", options->verbose, "the stages' times");
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
    command.add_flag("--quiet", options->quiet, "nothing but errors");
    command.add_flag("--verbose", options->verbose, "the range searched, and the stages' times");
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
    command.add_flag("--quiet", options->quiet, "nothing but errors");
    command.add_flag("--verbose", options->verbose, "the stages' times");
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
