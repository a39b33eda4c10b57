#include "pipeline/bench/cuda.h"

#include <nlohmann/json.hpp>
#include <ostream>

#include "pipeline/bench/bench_rows.h"
#include "pipeline/bench/cuda_experiments.h"
#include "pipeline/data/error.h"
#include "pipeline/files/output_set.h"
#include "pipeline/job/backend.h"

namespace hexrelief::bench {
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

// Returns JSON with one line per row, because there are some hundred.
std::string lines_text(const Json& head, const std::vector<Json>& rows) {
    std::string text = json_text(head, 1);
    text.erase(text.rfind('\n'));
    text += ",\n \"rows\": [";
    for (std::size_t i = 0; i < rows.size(); ++i) text += (i ? ",\n  " : "\n  ") + json_text(rows[i], -1);
    return text + "\n ]\n}\n";
}

}  // namespace

void run_bench_cuda(const CudaBenchOptions& options, std::ostream& out) {
    check_names(options.experiments, cuda_bench::experiment_names(), "--experiments");
    const paper::Config paper = paper_config_of_text(options);
    std::vector<std::string> missing;
    std::vector<FoundMap> found;
    if (!options.data.empty()) found = find_maps(options.data, {}, {}, missing);
    if (!options.json.empty()) files::check_writable_file(options.json);
    const int threads = job::effective_threads(options.threads);
    cuda_bench::Solvers solvers(threads);

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
    out << "paper: the paper's own program; hexrelief: ours on its schedule; default: ours on its own, "
           "without "
           "balancing; balanced: with it; som: config/som.yaml; cut: the mesh cut along silhouettes; cpu: as "
           "hexrelief, on the CPU.\n"
        << cuda_bench::headings() << std::flush;

    std::vector<Json> rows;
    cuda_bench::Bench bench{options,
                            found,
                            paper,
                            solvers,
                            [&](const cuda_bench::Row& row) {
                                out << cuda_bench::row_text(row) << std::flush;
                                rows.push_back(cuda_bench::row_json(row));
                            },
                            [&](const std::string& line) { out << line << '\n'
                                                               << std::flush; },
                            {}};
    for (const std::string& name : cuda_bench::experiment_names())
        if (wanted(options.experiments, name)) cuda_bench::run_experiment(bench, name);
    write_json(options.json, lines_text(head, rows));
}

}  // namespace hexrelief::bench
