#include <cstdio>
#include <memory>
#include <optional>

#include "pipeline/cli/arguments/config_options.h"
#include "pipeline/cli/terminal/printable.h"
#include "pipeline/cli/tiles/commands.h"
#include "pipeline/cli/tiles/stage_teller.h"
#include "pipeline/data/error.h"
#include "pipeline/files/interrupt.h"
#include "pipeline/tiles/make_plan.h"

namespace hexrelief {
namespace {

struct PlanOptions {
    std::filesystem::path map, color, folder;
    ConfigOptions config;
    std::string raw, calibration, unknown, backend;
    std::optional<double> scale, offset_px;
    int tile_vertices = 512, threads = 0;
    bool quiet = false, verbose = false;
};

Config config_of(const PlanOptions& options) {
    Config config = read_config(options.config);
    const auto apply = [&](const std::string& option, const char* path, const std::string& value) {
        if (!value.empty()) apply_option(config, option, path, value);
    };
    apply("--calib", "input.calibration.file", options.calibration);
    apply("--unknown", "input.disparity.unknown", options.unknown);
    apply("--backend", "run.backend", options.backend);
    if (options.scale) apply("--disparity-scale", "input.disparity.scale", shortest(*options.scale));
    if (options.offset_px)
        apply("--disparity-offset", "input.disparity.offset_px", shortest(*options.offset_px));
    if (options.threads > 0) apply("--threads", "run.threads", std::to_string(options.threads));
    finish_config(config);
    return config;
}

int plan_tiles(const PlanOptions& options) {
    PlanRequest request{options.map, options.color,         options.folder,
                        {},          options.tile_vertices, config_of(options)};
    if (!options.raw.empty()) request.raw = parse_raw_map_layout(options.raw);
    check_writable_folder(options.folder);
    check_overwrites(
        {plan_file(options.folder), plan_config_file(options.folder)},
        {options.map, options.color, options.config.file, request.config.input.calibration.file});
    const int threads = effective_threads(request.config.run.threads);
    const BackendPointer backend = Backends::for_one_run().get(request.config.run.backend, threads);
    install_interrupt_handling();

    StageTeller teller(options.quiet, options.verbose);
    RunLog& log = teller.log();
    const TilePlan plan = make_plan(request, *backend, log);
    backend->give_back();
    if (options.quiet) return 0;
    const LatticeTiling tiling = plan.tiling();
    std::printf("%s: %d x %d tiles, a lattice of %d x %d vertices; %.1f s\n",
                printable(options.folder.string()).c_str(), tiling.across(), tiling.down(), plan.columns,
                plan.rows, log.seconds());
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
        {.value = "N", .shows_default = true, .range = {{LatticeTiling::kLeastTile, 1000000}}});
    command.add_option("--color", &options->color, "the left image, of the map's size, for the texture",
                       {.value = "L"});
    command.add_option("--raw", &options->raw, "the map is samples alone: as 32768x32768,float32",
                       {.value = "WxH,TYPE"});
    command.add_option("--disparity-scale", &options->scale, "the map's samples divided by this are px",
                       {.value = "S"});
    command.add_option("--disparity-offset", &options->offset_px, "px added after the scale", {.value = "O"});
    command.add_option("--unknown", &options->unknown, "sample that means 'not known' in the map",
                       {.value = "V"});
    command.add_option("--calib", &options->calibration, "the camera, as 'hexrelief run' takes it",
                       {.value = "C"});
    add_config_options(command, options->config, "Options");
    command.add_option("--backend", &options->backend, "auto, cpu or cuda", {.value = "B"});
    command.add_option("--threads", &options->threads, "CPU threads; 0 = all",
                       {.shows_default = true, .range = {{0, 1024}}});
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

}  // namespace hexrelief
