// bench_paper [--data DIR] [--experiments LIST] ...: the paper's GPU experiments (sections 6.1 to 6.4), with
// the paper baseline (the program that the paper describes) and with ours, on the same device.
#include <CLI/CLI.hpp>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "pipeline/data/error.h"
#include "pipeline/job/backend.h"
#include "tests/cuda/paper/experiments.h"

namespace hexrelief::paper {
namespace {

using Json = nlohmann::ordered_json;

// Returns the values by their names.
template <typename Value>
std::map<std::string, Value> named(const auto& names) {
    std::map<std::string, Value> values;
    for (const char* const name : names) values.emplace(name, static_cast<Value>(values.size()));
    return values;
}

// Writes a row a line, because there are some hundred.
void write_json(const std::filesystem::path& path, Json head, const std::vector<Json>& rows) {
    std::ofstream file(path);
    std::string text = head.dump(1);
    text.erase(text.rfind('\n'));
    file << text << ",\n \"rows\": [";
    for (std::size_t i = 0; i < rows.size(); ++i) file << (i ? ",\n  " : "\n  ") << rows[i].dump();
    file << "\n ]\n}\n";
    if (!file.flush()) throw Error(ErrorKind::output, "cannot write " + path.string());
}

void run(const BenchOptions& options) {
    const std::vector<FoundMap> found =
        options.data.empty() ? std::vector<FoundMap>{} : find_maps(options.data);
    const int threads = job::effective_threads(options.threads);
    Solvers solvers(threads);
    std::cout << "cuda: " << solvers.device() << "; cpu: " << solvers.cpu() << ", threads " << threads
              << "\npaper: the paper's own program; hexrelief: ours on its schedule; default: ours on its "
                 "own, without balancing; balanced: with it; som: config/som.yaml; cut: the mesh cut along "
                 "silhouettes; cpu: as hexrelief, on the CPU."
              << std::endl;
    std::vector<Json> rows;
    Bench bench{options,
                found,
                solvers,
                [&](const Row& row) {
                    rows.push_back(row_json(row));
                    std::cout << rows.back() << std::endl;
                },
                [](const std::string& line) { std::cout << line << std::endl; },
                {}};
    for (const std::string& name : experiment_names())
        if (options.experiments.empty() ||
            std::count(options.experiments.begin(), options.experiments.end(), name))
            run_experiment(bench, name);
    if (options.json.empty()) return;
    write_json(options.json,
               {{"schema", 1},
                {"version", HEXRELIEF_VERSION},
                {"device", solvers.device()},
                {"cpu", solvers.cpu()},
                {"threads", threads},
                {"maps", options.data.empty() ? "made-up" : "Middlebury"}},
               rows);
}

}  // namespace
}  // namespace hexrelief::paper

int main(int count, char** words) {
    using namespace hexrelief;
    paper::BenchOptions options;
    options.paper.memory = paper::Memory::version2;
    int block = 8;  // the paper's fastest with co 20
    CLI::App program("The paper's GPU experiments: its own program and ours on this machine's device");
    program.add_option("--data", options.data, "folder with Middlebury's sets; without it a made-up scene");
    program.add_option("--experiments", options.experiments)
        ->delimiter(',')
        ->check(CLI::IsMember(paper::experiment_names()));
    program.add_option("--runs", options.runs, "timed runs of a row")->check(CLI::PositiveNumber);
    program
        .add_option("--sweep-runs", options.sweep_runs,
                    "the same in sweeps, above 2^24 px, and for the paper's program in all but size")
        ->check(CLI::PositiveNumber);
    program.add_option("--largest", options.largest, "side of the largest made-up map, px")
        ->check(CLI::Range(512, 32767));
    program.add_option("--kernels", options.paper.kernels, "the paper's program")
        ->transform(CLI::CheckedTransformer(paper::named<paper::Kernels>(paper::kKernelsNames)));
    program.add_option("--memory", options.paper.memory, "the paper's program: its Fig. 7 and 8")
        ->transform(CLI::CheckedTransformer(paper::named<paper::Memory>(paper::kMemoryNames)));
    program.add_option("--block", block, "the paper's program: threads of a block")
        ->check(CLI::Range(1, 1024));
    program.add_option("--threads", options.threads, "0 = all");
    program.add_option("--json", options.json, "write the rows as JSON, too (samples/paper/plot.py)");
    CLI11_PARSE(program, count, words);
    paper::set_block(options.paper, block);
    try {
        paper::run(options);
    } catch (const Error& error) {
        std::cerr << "bench_paper: " << error.what() << '\n';
        return static_cast<int>(error.kind());
    }
}
