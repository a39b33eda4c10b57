#include <cstdio>
#include <memory>

#include "pipeline/cli/arguments/config_options.h"
#include "pipeline/cli/terminal/printable.h"
#include "pipeline/cli/tiles/stage_teller.h"
#include "pipeline/cli/tiles/tiles_commands.h"
#include "pipeline/files/interrupt.h"
#include "pipeline/files/output_set.h"
#include "pipeline/library/conversions.h"
#include "pipeline/tiles/matching/match_in_tiles.h"

namespace hexrelief::cli {
namespace {

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
    add_config_options(command, options->config, "Options");
    add_key_options(command, options->config, {"--calib", "--backend", "--threads"}, "Options");
    command.add_flag("--quiet", options->quiet, "nothing but errors");
    command.add_flag("--verbose", options->verbose, "the range searched, and the stages' times");
    command.set_footer(
        "Each tile is matched with the pixels around it, as 'hexrelief run' matches a pair. Of TIFF, "
        "BigTIFF,\n"
        "PGM and PPM no more is read than a tile needs; other pictures are held as a whole. The map is of\n"
        "32-bit floats in px, unknown where nothing matches. The camera's ndisp, if its file has one, is "
        "the\n"
        "range that is searched.\n\n"
        "Example:\n"
        "  hexrelief tiles match left.tif right.tif -o map.tif --set disparity.num_disparities_px=256\n"
        "  hexrelief tiles plan map.tif -o relief --color left.tif");
    command.set_action([options] { return match_tiles(*options); });
}

}  // namespace hexrelief::cli
