#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "pipeline/batch/table.h"
#include "pipeline/batch/worker.h"
#include "pipeline/cli/arguments/argument_parser.h"
#include "pipeline/cli/commands.h"
#include "pipeline/cli/printable.h"
#include "pipeline/config/options.h"
#include "pipeline/data/clock.h"
#include "pipeline/data/error.h"
#include "pipeline/files/interrupt.h"
#include "pipeline/tiles/solve_tiles.h"
#include "pipeline/tiles/tile_output.h"

namespace hexrelief::cli {
namespace {

namespace fs = std::filesystem;

struct SolveOptions {
    fs::path folder;
    std::string tile, shard, gpus, memory;
    Options config;
    int jobs = 0, threads = 0;
    bool force = false, print_commands = false, quiet = false;
};

std::vector<tiles::TileNumber> wanted_tiles(const tiles::TilePlan& plan, const SolveOptions& options) {
    const std::vector<tiles::TileNumber> all = tiles::tiles_of_level(plan, plan.finest_level());
    if (!options.tile.empty()) {
        const auto tile = std::ranges::find_if(all, [&](const tiles::TileNumber& one) {
            return std::to_string(one.j) + "," + std::to_string(one.i) == options.tile;
        });
        if (tile == all.end())
            throw Error(ErrorKind::usage, "--tile: must be ROW,COLUMN from 0,0 to " +
                                              std::to_string(all.back().j) + "," +
                                              std::to_string(all.back().i) + ", not '" + options.tile + "'");
        return {*tile};
    }
    const Shard shard = parse_shard(options.shard);
    std::vector<tiles::TileNumber> tiles;
    for (std::size_t k = shard.number - 1; k < all.size(); k += shard.of) tiles.push_back(all[k]);
    return tiles;
}

int print_commands(const SolveOptions& options, const std::vector<tiles::TileNumber>& tiles) {
    for (const tiles::TileNumber& tile : tiles) {
        std::vector<std::string> words = {"hexrelief", "tiles",
                                          "solve",     fs::absolute(options.folder).string(),
                                          "--tile",    std::to_string(tile.j) + "," + std::to_string(tile.i)};
        for (const auto& [flag, text] : options.config.direct) words.insert(words.end(), {flag, text});
        if (options.threads > 0) words.insert(words.end(), {"--threads", std::to_string(options.threads)});
        if (options.force) words.emplace_back("--force");
        std::printf("%s\n", config::shell_line(words).c_str());
    }
    return 0;
}

class TileTeller {
  public:
    TileTeller(const tiles::TilePlan& plan, std::size_t tiles, std::size_t up_to_date, bool is_quiet)
        : plan_(plan), is_quiet_(is_quiet), has_bar_(!is_quiet && isatty(STDERR_FILENO)) {
        counts_.units = tiles;
        counts_.up_to_date = up_to_date;
    }
    void tile_ended(const tiles::TileNumber& tile, const std::string& failure, int exit_code) {
        counts_.add(failure.empty() ? batch::UnitOutcome::done : batch::UnitOutcome::failed);
        if (!failure.empty()) {
            clear();
            std::fprintf(stderr, "hexrelief: tile %s: %s\n", tiles::tile_name(plan_, tile).c_str(),
                         printable(failure).c_str());
            if (exit_code_ == 0) exit_code_ = exit_code;
        }
        if (has_bar_) std::fprintf(stderr, "\r%s\x1b[K", batch::progress_bar(counts_, seconds()).c_str());
    }
    int all_ended() {
        clear();
        if (!is_quiet_)
            std::printf("%zu tiles in %.1f s: %zu done, %zu up to date, %zu failed\n", counts_.units,
                        seconds(), counts_.done, counts_.up_to_date, counts_.failed);
        end_telling();
        return exit_code_;
    }

  private:
    double seconds() const { return now_seconds() - begun_; }
    void clear() const {
        if (has_bar_) std::fputs("\r\x1b[K", stderr);
    }
    const tiles::TilePlan& plan_;
    bool is_quiet_, has_bar_;
    batch::BatchCounts counts_;
    int exit_code_ = 0;
    double begun_ = now_seconds();
};

config::BackendChoice backend_of(const SolveOptions& options, const config::Config& planned) {
    config::Config config = planned;
    apply_options(config, options.config.direct, {});
    return config.run.backend;
}

// Solves the tiles in this process and returns the exit code. memory: bytes for all tiles together; 0 = a
// share of the free memory.
int solve_here(const tiles::TilePlan& plan, const std::vector<tiles::TileNumber>& tiles,
               const SolveOptions& options, int threads, std::uint64_t memory) {
    std::vector<tiles::TileNumber> missing;
    for (const tiles::TileNumber& tile : tiles)
        if (options.force || !tiles::is_solved(plan, tile)) missing.push_back(tile);
    TileTeller teller(plan, tiles.size(), tiles.size() - missing.size(), options.quiet);
    if (missing.empty()) return teller.all_ended();
    const job::BackendPointer backend =
        job::Backends::for_one_run().get(backend_of(options, plan.config), threads);
    files::install_interrupt_handling();
    const tiles::SolveSettings settings{threads, options.jobs, memory};
    tiles::solve_tiles(plan, missing, *backend, settings,
                       {[&](const tiles::TileNumber& tile, const std::string& failure, int exit_code) {
                           teller.tile_ended(tile, failure, exit_code);
                       }});
    backend->give_back();
    return teller.all_ended();
}

// Solves the tiles in one process per device, each with every n-th tile and its share of threads and memory.
// Returns the first exit code other than 0.
int solve_on(const std::vector<std::string>& devices, const tiles::TilePlan& plan,
             const std::vector<tiles::TileNumber>& tiles, const SolveOptions& options, int threads,
             std::uint64_t memory) {
    if (memory == 0) memory = batch::memory_to_use();
    const int share = std::max(1, threads / static_cast<int>(devices.size()));
    std::vector<pid_t> children;
    for (std::size_t k = 0; k < devices.size(); ++k) {
        const pid_t child = fork();
        if (child < 0) throw Error(ErrorKind::device, "--gpus: no process for another device");
        if (child > 0) {
            children.push_back(child);
            continue;
        }
        setenv("CUDA_VISIBLE_DEVICES", devices[k].c_str(), 1);
        std::vector<tiles::TileNumber> own;
        for (std::size_t t = k; t < tiles.size(); t += devices.size()) own.push_back(tiles[t]);
        int code = 1;
        try {
            code = solve_here(plan, own, options, share, memory / devices.size());
        } catch (...) {
            const batch::UnitResult failed = batch::result_of_exception();
            std::fprintf(stderr, "hexrelief: %s\n", printable(failed.message).c_str());
            code = failed.exit_code;
        }
        std::fflush(stdout);
        _exit(code);
    }
    int exit_code = 0;
    for (const pid_t child : children) {
        int status = 0;
        waitpid(child, &status, 0);
        const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 1;
        if (exit_code == 0) exit_code = code;
    }
    return exit_code;
}

int solve(const SolveOptions& options) {
    const tiles::TilePlan plan = tiles::read_plan(options.folder);
    const std::vector<tiles::TileNumber> tiles = wanted_tiles(plan, options);
    if (options.print_commands) return print_commands(options, tiles);
    const int threads = job::effective_threads(options.threads);
    const std::uint64_t memory = parse_memory(options.memory);
    const std::vector<std::string> devices = batch::devices_of(options.gpus);
    return devices.size() > 1 ? solve_on(devices, plan, tiles, options, threads, memory)
                              : solve_here(plan, tiles, options, threads, memory);
}

}  // namespace

void add_solve_command(Command& group) {
    Command command = group.add_command("solve", "the tiles of a plan, those that are not there yet");
    const auto options = std::make_shared<SolveOptions>();
    command.add_option("folder", &options->folder, "of 'hexrelief tiles plan'",
                       {.value = "DIR", .required = true});
    command.add_option("--tile", &options->tile, "one tile alone, counted from 0,0", {.value = "ROW,COLUMN"});
    command.add_option("--shard", &options->shard, "every N-th tile from tile K on",
                       {.value = "K/N", .excludes = "--tile"});
    command.add_option("--jobs", &options->jobs,
                       "tiles at a time; 0 = one a thread, if there is memory for them",
                       {.value = "N", .shows_default = true, .range = {{0, 1024}}});
    command.add_option("--threads", &options->threads, "of all tiles together; 0 = all",
                       {.value = "N", .shows_default = true, .range = {{0, 1024}}});
    command.add_option("--memory", &options->memory,
                       "for all tiles together, as 8G; otherwise three quarters of what is free",
                       {.value = "SIZE"});
    add_key_options(command, options->config, {"--backend"}, "Options");
    command.add_option("--gpus", &options->gpus, "all, or a number: the tiles are spread over these devices",
                       {.value = "all|N"});
    command.add_flag("--force", options->force, "solve tiles that are there as well");
    command.add_flag("--print-commands", options->print_commands,
                     "print a command a tile, for a shell or a cluster; do nothing");
    command.add_flag("--quiet", options->quiet, "nothing but failures");
    command.set_footer(
        R"(Each tile is solved by itself, in any order, on any machine that sees DIR, the map and the picture;
its files appear together, its report DIR/tiles/LEVEL/COLUMN/ROW.json as the last. A second call does what
is missing, failed, or no longer as the report says.

Examples:
  hexrelief tiles solve relief
  hexrelief tiles solve relief --shard 3/16      (one of 16 processes)
  hexrelief tiles solve relief --print-commands | parallel)");
    command.set_action([options] { return solve(*options); });
}

}  // namespace hexrelief::cli
