#include <cstdio>
#include <memory>

#include "pipeline/cli/arguments/config_options.h"
#include "pipeline/cli/terminal/printable.h"
#include "pipeline/cli/tiles/stage_teller.h"
#include "pipeline/cli/tiles/tiles_commands.h"
#include "pipeline/data/error.h"
#include "pipeline/files/interrupt.h"
#include "pipeline/library/conversions.h"
#include "pipeline/tiles/make_plan.h"

namespace hexrelief::cli {
namespace {

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

}  // namespace

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
        "The lattice of the whole map is solved at half of its size, and what lies beside the borders of "
        "the\n"
        "tiles on the map itself. Each tile is then solved by itself, by 'hexrelief tiles solve DIR', and "
        "all\n"
        "fit together to the bit. The map, and the picture, must stay as they are until then.\n\n"
        "Of the presets compact needs --set surface.silhouette_rounds=0 beside it, quality needs\n"
        "--set density.detail=0, and paper and som, which do not balance, are none for tiles.\n\n"
        "Example:\n"
        "  hexrelief tiles plan map.tif -o relief --set export.compression=draco");
    command.set_action([options] { return plan_tiles(*options); });
}

}  // namespace hexrelief::cli
