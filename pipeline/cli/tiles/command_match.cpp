#include <cstdio>
#include <memory>

#include "pipeline/cli/arguments/config_options.h"
#include "pipeline/cli/terminal/printable.h"
#include "pipeline/cli/tiles/commands.h"
#include "pipeline/cli/tiles/stage_teller.h"
#include "pipeline/files/interrupt.h"
#include "pipeline/files/output_set.h"
#include "pipeline/tiles/matching/match_in_tiles.h"

namespace hexrelief {
namespace {

struct MatchOptions {
    std::filesystem::path left, right, output;
    ConfigOptions config;
    std::string calibration, backend;
    int tile_px = MatchRequest().tile_px, threads = 0;
    bool quiet = false, verbose = false;
};

Config config_of(const MatchOptions& options) {
    Config config = read_config(options.config);
    const auto apply = [&](const std::string& option, const char* path, const std::string& value) {
        if (!value.empty()) apply_option(config, option, path, value);
    };
    apply("--calib", "input.calibration.file", options.calibration);
    apply("--backend", "run.backend", options.backend);
    if (options.threads > 0) apply("--threads", "run.threads", std::to_string(options.threads));
    finish_config(config);
    return config;
}

int match_tiles(const MatchOptions& options) {
    const MatchRequest request{.left = options.left,
                               .right = options.right,
                               .map = options.output,
                               .tile_px = options.tile_px,
                               .config = config_of(options)};
    check_writable_file(options.output);
    const int threads = effective_threads(request.config.run.threads);
    const BackendPointer backend = Backends::for_one_run().get(request.config.run.backend, threads);
    install_interrupt_handling();

    StageTeller teller(options.quiet, options.verbose);
    RunLog& log = teller.log();
    const TiledMatch match = match_in_tiles(request, *backend, log);
    backend->give_back();
    if (!options.quiet)
        std::printf("%s: %dx%d px in %d tiles, %.1f %% matched, %.1f %% known; %.1f s\n",
                    printable(options.output.string()).c_str(), match.width, match.height, match.tiles,
                    100 * match.matched_share, 100 * match.known_share, log.seconds());
    return 0;
}

}  // namespace

void add_match_command(Command& group) {
    Command command = group.add_command("match", "a rectified pair of any size to its disparity map");
    const auto options = std::make_shared<MatchOptions>();
    command.add_option("left", &options->left, "the left picture", {.value = "LEFT", .required = true});
    command.add_option("right", &options->right, "the right picture", {.value = "RIGHT", .required = true});
    command.add_option("-o,--output", &options->output, "map.tif (BigTIFF in tiles) or map.pfm",
                       {.value = "MAP", .required = true});
    command.add_option("--tile", &options->tile_px, "a tile's side",
                       {.value = "PX", .shows_default = true, .range = {{64, 16384}}});
    command.add_option("--calib", &options->calibration, "the camera, whose ndisp is the range to search",
                       {.value = "C"});
    add_config_options(command, options->config, "Options");
    command.add_option("--backend", &options->backend, "auto, cpu or cuda", {.value = "B"});
    command.add_option("--threads", &options->threads, "CPU threads; 0 = all",
                       {.shows_default = true, .range = {{0, 1024}}});
    command.add_flag("--quiet", options->quiet, "nothing but errors");
    command.add_flag("--verbose", options->verbose, "the range searched, and the stages' times");
    command.set_footer(
        "Each tile is matched with the pixels around it, as 'hexrelief run' matches a pair. Of TIFF, "
        "BigTIFF,\n"
        "PGM and PPM no more is read than a tile needs; other pictures are held as a whole. The map is of\n"
        "32-bit floats in px, unknown where nothing matches.\n\n"
        "Example:\n"
        "  hexrelief tiles match left.tif right.tif -o map.tif --set disparity.num_disparities_px=256\n"
        "  hexrelief tiles plan map.tif -o relief --color left.tif");
    command.set_action([options] { return match_tiles(*options); });
}

}  // namespace hexrelief
