#include <iostream>
#include <memory>
#include <optional>

#include "pipeline/bench/batch/bench_batch.h"
#include "pipeline/bench/batch/files.h"
#include "pipeline/bench/cuda.h"
#include "pipeline/bench/match/match.h"
#include "pipeline/bench/rd.h"
#include "pipeline/bench/sparse/sparse.h"
#include "pipeline/bench/table2.h"
#include "pipeline/cli/commands.h"

namespace hexrelief::cli {
namespace {

void add_threads_option(Command& command, int& threads) {
    command.add_option("--threads", &threads, "CPU threads; 0 = all",
                       {.shows_default = true, .range = {{0, 1024}}});
}

void add_table2(Command& group) {
    Command command = group.add_command("table2", "the paper's Table 2: time and quality of the mesh stage");
    const auto options = std::make_shared<bench::Table2Options>();
    command.add_option("--data", &options->data, "folder with Middlebury's sets",
                       {.value = "DIR", .required = true});
    command.add_option("--runs", &options->runs, "timed runs of each method",
                       {.shows_default = true, .range = {{1, 1000}}});
    command.add_option("--sequential-runs", &options->sequential_runs,
                       "the same for the sequential method; 0 = --runs on small maps, else one",
                       {.shows_default = true, .range = {{0, 1000}}});
    add_threads_option(command, options->threads);
    command.add_option("--json", &options->json, "write the table as JSON, too", {.value = "FILE"});
    command.add_option("--maps", &options->maps, "the paper's names, such as cones,conesM",
                       {.value = "NAMES", .comma_separated = true});
    command.add_option("--methods", &options->methods, "of sequential, paper, som, default",
                       {.value = "NAMES", .comma_separated = true});
    command.add_option(
        "--set", &options->settings,
        "override one key of density or mesh of the default method; may be given several times",
        {.value = "key.path=value", .repeated = true});
    command.set_footer(
        "Examples:\n"
        "  hexrelief bench table2 --data middlebury\n"
        "  hexrelief bench table2 --data middlebury --methods default --set "
        "density.background.method=fraction "
        "--set density.floor=0\n"
        "  hexrelief bench table2 --data middlebury --maps cones,conesM,conesL --methods paper,default "
        "--json table2.json");
    command.set_action([options] {
        bench::run_bench_table2(*options, std::cout);
        return 0;
    });
}

void add_rd(Command& group) {
    Command command = group.add_command("rd", "bytes against error: presets, uniform grids, simplification");
    const auto options = std::make_shared<bench::RdOptions>();
    command.add_option("--data", &options->data, "folder with Middlebury's sets",
                       {.value = "DIR", .required = true});
    command.add_option("--maps", &options->maps, "the paper's names, such as cones,conesL",
                       {.value = "NAMES", .comma_separated = true});
    command.add_option("--methods", &options->methods,
                       "of default, quality, compact, paper, uniform, meshopt, "
                       "meshopt+cut; uniform is always there",
                       {.value = "NAMES", .comma_separated = true});
    command.add_option(
        "--peer", &options->peers,
        "meshes of another program to compare with: DIR/MAP_*.obj, vertices x y disparity in px",
        {.value = "NAME=DIR", .repeated = true});
    command.add_option("--spacings", &options->spacings, "of the lattices and grids, px",
                       {.value = "PX", .comma_separated = true, .shows_default = true});
    command.add_option("--set", &options->settings,
                       "override one key of every preset; may be given several times",
                       {.value = "key.path=value", .repeated = true});
    add_threads_option(command, options->threads);
    command.add_option("--json", &options->json, "write all figures as JSON, too", {.value = "FILE"});
    command.set_footer(
        "Examples:\n"
        "  hexrelief bench rd --data middlebury --json rd.json\n"
        "  samples/plot_rd.py rd.json rd.png\n"
        "  hexrelief bench rd --data middlebury --maps cones,aloe --methods default,meshopt+cut");
    command.set_action([options] {
        bench::run_bench_rd(*options, std::cout);
        return 0;
    });
}

struct MatchCommandOptions {
    bench::MatchOptions match;
    std::optional<double> noise_percent, gamma, gain;
};

void add_match(Command& group) {
    Command command = group.add_command("match", "matchers on pairs: quality against the truth, and time");
    const auto options = std::make_shared<MatchCommandOptions>();
    bench::MatchOptions& match = options->match;
    command.add_option("--data", &match.data,
                       "folder with scenes at any depth, such as Middlebury's sets: left.*, right.*, disp.*",
                       {.value = "DIR", .required = true});
    command.add_option("--scenes", &match.scenes, "the names of their folders, such as cones-quarter,Piano",
                       {.value = "NAMES", .comma_separated = true});
    command.add_option("--methods", &match.methods,
                       "of sgm, sgbm, opencv (StereoSGBM's own answer: not filled, not refined)",
                       {.value = "NAMES", .comma_separated = true});
    command.add_option("--runs", &match.runs, "timed runs of each method",
                       {.shows_default = true, .range = {{1, 1000}}});
    add_threads_option(command, match.threads);
    command.add_option("--noise", &options->noise_percent,
                       "standard deviation of noise added to both images, percent of 255",
                       {.value = "PERCENT"});
    command.add_option("--gamma", &options->gamma, "exponent of another light on the right image",
                       {.value = "G"});
    command.add_option("--gain", &options->gain, "factor of another light on the right image",
                       {.value = "G"});
    command.add_option("--set", &match.settings, "override one key; may be given several times",
                       {.value = "key.path=value", .repeated = true});
    command.add_option("--json", &match.json, "write the rows as JSON, too", {.value = "FILE"});
    command.set_footer(
        "Figures are those of hexrelief evaluate; scenes whose names end in -full take --discontinuity 2.\n\n"
        "Examples:\n"
        "  hexrelief bench match --data middlebury --json match.json\n"
        "  samples/plot_match.py match.json match.png\n"
        "  hexrelief bench match --data middlebury --scenes cones-quarter,aloe-third --noise 3 --runs 1");
    command.set_action([options] {
        bench::match::Disturbance& disturbance = options->match.disturbance;
        if (options->noise_percent) disturbance.noise_percent = *options->noise_percent;
        if (options->gamma) disturbance.gamma = *options->gamma;
        if (options->gain) disturbance.gain = *options->gain;
        bench::run_bench_match(options->match, std::cout);
        return 0;
    });
}

void add_sparse(Command& group) {
    Command command =
        group.add_command("sparse", "maps thinned as a laser's are: what that costs the surface");
    const auto options = std::make_shared<bench::SparseOptions>();
    command.add_option("--data", &options->data,
                       "folder with scenes at any depth, such as Middlebury's sets: left.*, right.*, disp.*",
                       {.value = "DIR", .required = true});
    command.add_option("--scenes", &options->scenes,
                       "the names of their folders, such as cones-quarter,Piano",
                       {.value = "NAMES", .comma_separated = true});
    command.add_option("--patterns", &options->patterns, "of random-20, random-5, rows-20, rows-5, laser",
                       {.value = "NAMES", .comma_separated = true});
    command.add_option("--preset", &options->preset, "default, quality, compact, paper, or a YAML file",
                       {.value = "NAME", .shows_default = true});
    command.add_flag("--without-picture", options->without_picture, "fill the maps without the left picture");
    command.add_option("--set", &options->settings, "override one key; may be given several times",
                       {.value = "key.path=value", .repeated = true});
    add_threads_option(command, options->threads);
    command.add_option("--json", &options->json, "write the rows as JSON, too", {.value = "FILE"});
    command.set_footer(
        "Example:\n"
        "  hexrelief bench sparse --data middlebury --scenes cones-quarter,teddy-quarter");
    command.set_action([options] {
        bench::run_bench_sparse(*options, std::cout);
        return 0;
    });
}

void add_batch(Command& group) {
    Command command = group.add_command("batch", "jobs a second: pairs in memory to GLB in memory");
    const auto options = std::make_shared<bench::BatchOptions>();
    command.add_option("--data", &options->data,
                       "folder with scenes at any depth, such as Middlebury's sets: left.*, right.*, disp.*",
                       {.value = "DIR", .required = true});
    command.add_option("--scenes", &options->scenes, "the names of their folders, such as cones-quarter",
                       {.value = "NAMES", .comma_separated = true});
    command.add_option("--jobs", &options->jobs, "timed jobs of each scene and backend",
                       {.shows_default = true, .range = {{1, 1000000}}});
    add_threads_option(command, options->threads);
    command.add_option("--workers", &options->workers,
                       "jobs at a time, which share the threads; 0 = one for each thread",
                       {.shows_default = true, .range = {{0, 1024}}});
    command.add_option("--set", &options->settings, "override one key; may be given several times",
                       {.value = "key.path=value", .repeated = true});
    command.add_flag(
        "--files", options->files,
        "as 'hexrelief batch', from files to files: --workers at a time against one, a thread each");
    command.add_option("--json", &options->json, "write the rows as JSON, too", {.value = "FILE"});
    command.set_footer(
        "Each worker keeps its backend from job to job. Its first job is not timed: it starts the device.\n\n"
        "Example:\n"
        "  hexrelief bench batch --data middlebury --scenes cones-quarter --jobs 1000");
    command.set_action([options] {
        if (options->files)
            bench::run_bench_batch_files(*options, std::cout);
        else
            bench::run_bench_batch(*options, std::cout);
        return 0;
    });
}

void add_cuda(Command& group) {
    Command command = group.add_command(
        "cuda", "the paper's GPU experiments: its own program and ours on this machine's device");
    const auto options = std::make_shared<bench::CudaBenchOptions>();
    command.add_option("--data", &options->data, "folder with Middlebury's sets; without it a made-up scene",
                       {.value = "DIR"});
    command.add_option("--experiments", &options->experiments,
                       "of memory, blocks, kernels, tradeoff, iterations, size",
                       {.value = "LIST", .comma_separated = true});
    command.add_option("--runs", &options->runs, "timed runs of a row",
                       {.shows_default = true, .range = {{1, 1000}}});
    command.add_option(
        "--sweep-runs", &options->sweep_runs,
        "the same in sweeps, above 2^24 px, and for the paper's program in all experiments but size",
        {.shows_default = true, .range = {{1, 1000}}});
    command.add_option("--largest", &options->largest, "side of the largest made-up map, px",
                       {.shows_default = true, .range = {{512, 32767}}});
    command.add_option("--kernels", &options->kernels, "the paper's program: single or multiple",
                       {.value = "K", .shows_default = true});
    command.add_option("--memory", &options->memory,
                       "the paper's program: 1, 2 or 2-texture (its Fig. 7 and 8)",
                       {.value = "M", .shows_default = true});
    command.add_option("--block", &options->block, "the paper's program: threads of a block",
                       {.shows_default = true, .range = {{1, 1024}}});
    add_threads_option(command, options->threads);
    command.add_option("--json", &options->json, "write the rows as JSON, too", {.value = "FILE"});
    command.set_footer(
        "Examples:\n"
        "  hexrelief bench cuda --experiments size --largest 4096\n"
        "  hexrelief bench cuda --data middlebury --json cuda.json   (then samples/paper/plot.py cuda.json)");
    command.set_action([options] {
        bench::run_bench_cuda(*options, std::cout);
        return 0;
    });
}

}  // namespace

void add_bench_command(Command& program) {
    Command group = program.add_command("bench", "measure time and quality");
    group.set_footer(
        "Examples:\n  hexrelief bench table2 --data middlebury --json table2.json\n"
        "  hexrelief bench rd --data middlebury --json rd.json\n"
        "  hexrelief bench match --data middlebury --json match.json\n"
        "  hexrelief bench batch --data middlebury --scenes cones-quarter\n"
        "  hexrelief bench cuda --data middlebury --json cuda.json");
    add_table2(group);
    add_rd(group);
    add_match(group);
    add_sparse(group);
    add_batch(group);
    add_cuda(group);
}

}  // namespace hexrelief::cli
