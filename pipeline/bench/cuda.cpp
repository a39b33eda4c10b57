#include "pipeline/bench/cuda.h"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "exporters/core/file_transaction.h"
#include "pipeline/bench/cuda_experiments.h"
#include "pipeline/data/error.h"
#include "pipeline/job/backend.h"
#include "pipeline/job/output_set.h"

namespace hexrelief {
namespace {

using Json = nlohmann::ordered_json;
using namespace cuda_bench;

const std::vector<std::string> kKernels{"single", "multiple"}, kMemories{"1", "2", "2-texture"};

paper::Config paper_config_of_text(const CudaBenchOptions& options) {
    check_names({options.kernels}, kKernels, "--kernels");
    check_names({options.memory}, kMemories, "--memory");
    paper::Config config;
    config.kernels = options.kernels == "single" ? paper::Kernels::single : paper::Kernels::multiple;
    config.memory = options.memory == "1"   ? paper::Memory::version1
                    : options.memory == "2" ? paper::Memory::version2
                                            : paper::Memory::version2_texture;
    config.block_single = config.block_extraction = config.block_search = config.block_learning =
        options.block;
    return config;
}

// A row a line: there are some hundred.
std::string json_text(const Json& head, const std::vector<Json>& rows) {
    std::string text = head.dump(1);
    text.erase(text.rfind('\n'));
    text += ",\n \"rows\": [";
    for (std::size_t i = 0; i < rows.size(); ++i) text += (i ? ",\n  " : "\n  ") + rows[i].dump();
    return text + "\n ]\n}\n";
}

}  // namespace

void run_bench_cuda(const CudaBenchOptions& options, std::ostream& out) {
    check_names(options.experiments, experiment_names(), "--experiments");
    const paper::Config paper = paper_config_of_text(options);
    std::vector<std::string> missing;
    std::vector<FoundMap> found;
    if (!options.data.empty()) found = find_maps(options.data, {}, {}, missing);
    if (!options.json.empty()) check_writable_file(options.json);
    const int threads = effective_threads(options.threads);
    Solvers solvers(threads);

    Json head;
    head["schema"] = 1;
    head["version"] = HEXRELIEF_VERSION;
    head["device"] = solvers.device();
    head["cpu"] = solvers.cpu();
    head["threads"] = threads;
    head["maps"] = options.data.empty() ? "made-up" : "Middlebury";
    head["missing"] = missing;
    out << "cuda: " << solvers.device() << "; cpu: " << solvers.cpu() << ", threads " << threads << '\n';
    for (const std::string& name : missing) out << "not there, left out: " << name << '\n';
    out << "literal: the paper's program; hexrelief: ours on its schedule; default: ours without balancing, "
           "balanced: with it; cpu: ours on the paper's schedule.\n"
        << headings() << std::flush;

    std::vector<Json> rows;
    Bench bench{options,
                found,
                paper,
                solvers,
                [&](const Row& row) {
                    out << row_text(row) << std::flush;
                    rows.push_back(row_json(row));
                },
                [&](const std::string& line) { out << line << '\n'
                                                   << std::flush; },
                {}};
    for (const std::string& name : experiment_names())
        if (wanted(options.experiments, name)) run_experiment(bench, name);
    if (options.json.empty()) return;
    FileTransaction files;
    files.write(options.json, json_text(head, rows));
    files.commit();
}

void register_bench_cuda(CLI::App& group, Action& chosen) {
    CLI::App* command = group.add_subcommand(
        "cuda", "the paper's GPU experiments: its own program and ours on this machine's device");
    const auto options = std::make_shared<CudaBenchOptions>();
    command->add_option("--data", options->data, "folder with Middlebury's sets; none: a made-up scene")
        ->type_name("DIR");
    command
        ->add_option("--experiments", options->experiments,
                     "of memory, blocks, kernels, tradeoff, iterations, size")
        ->delimiter(',')
        ->type_name("LIST");
    command->add_option("--runs", options->runs, "timed runs of a row")
        ->capture_default_str()
        ->check(CLI::Range(1, 1000));
    command
        ->add_option("--sweep-runs", options->sweep_runs,
                     "the same for the paper's program outside size, in sweeps, and above 2^24 px")
        ->capture_default_str()
        ->check(CLI::Range(1, 1000));
    command->add_option("--largest", options->largest, "side of the largest made-up map, px")
        ->capture_default_str()
        ->check(CLI::Range(512, 32767));
    command->add_option("--kernels", options->kernels, "the paper's program: single or multiple")
        ->capture_default_str()
        ->type_name("K");
    command
        ->add_option("--memory", options->memory, "the paper's program: 1, 2 or 2-texture (its Fig. 7 and 8)")
        ->capture_default_str()
        ->type_name("M");
    command->add_option("--block", options->block, "the paper's program: threads of a block")
        ->capture_default_str()
        ->check(CLI::Range(1, 1024));
    command->add_option("--threads", options->threads, "CPU threads; 0 = all")
        ->capture_default_str()
        ->check(CLI::Range(0, 1024));
    command->add_option("--json", options->json, "write the rows as JSON, too")->type_name("FILE");
    command->footer(
        "Examples:\n"
        "  hexrelief bench cuda --experiments size --largest 4096\n"
        "  hexrelief bench cuda --data middlebury --json cuda.json   (then samples/paper/plot.py cuda.json)");
    command->callback([options, &chosen] {
        chosen = [options] {
            run_bench_cuda(*options, std::cout);
            return 0;
        };
    });
}

}  // namespace hexrelief
