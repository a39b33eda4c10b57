#include <cstdio>
#include <memory>

#include "pipeline/cli/terminal/printable.h"
#include "pipeline/cli/tiles/stage_teller.h"
#include "pipeline/cli/tiles/tiles_commands.h"
#include "pipeline/files/interrupt.h"
#include "pipeline/job/backend.h"
#include "pipeline/tiles/merge_tiles.h"

namespace hexrelief::cli {
namespace {

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

}  // namespace

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
    command.set_footer(
        "Beside FILE.json is FILE.implicit.json, the same tileset by implicit tiling, with its subtrees/. "
        "Both\n"
        "show the GLB files below DIR, which must keep its place beside them. Every edge between two tiles "
        "is\n"
        "looked up in both first.\n\n"
        "Example:\n"
        "  hexrelief tiles merge relief -o relief/tileset.json");
    command.set_action([options] { return merge(*options); });
}

}  // namespace hexrelief::cli
