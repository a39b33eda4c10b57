#include "tests/cuda/paper/experiments.h"

#include <algorithm>
#include <cmath>

#include "pipeline/data/error.h"
#include "pipeline/stages/density.h"
#include "tests/cuda/paper/balls_scene.h"

namespace hexrelief::paper {
namespace {

constexpr long long kManyPixels = 1LL << 24;
constexpr long long kMostCpuPixels = 1LL << 24;  // the CPU takes seconds for more
constexpr double kSigma = 24;                    // Table 1; 12 only in section 6.4
const std::vector<int> kBlocks{1, 8, 16, 32, 64, 128, 256};

// Returns the paper's density, as in config/paper.yaml.
stages::DensityConfig paper_density() {
    return {.scale_percentile = 100, .background_method = stages::BackgroundMethod::fraction, .floor = 0};
}

// Returns the schedule of config/som.yaml.
MeshConfig som_config() {
    return {.t_max = 60,
            .prr = 2,
            .prr_final = 10,
            .magnification = 1.3,
            .border = MeshBorder::slide,
            .balance = {.enabled = false}};
}

Case made_up_case(int width, int height) {
    Case c{"made-up", made_up_scene(width, height), {}};
    c.density = stages::compute_density(c.disparity, paper_density());
    return c;
}

Case case_of(const FoundMap& found) {
    Case c{found.map.name, load_map(found), {}};
    c.density = stages::compute_density(c.disparity, paper_density());
    return c;
}

// Calls work for the paper's maps of these names that were found, or, if there are none, for the synthetic
// scene at their usual sizes.
void for_each_case(const Bench& bench, const std::vector<std::string>& names,
                   const std::vector<std::pair<int, int>>& sizes,
                   const std::function<void(const Case&)>& work) {
    bool any = false;
    for (const FoundMap& map : bench.found) {
        if (std::find(names.begin(), names.end(), map.map.name) == names.end()) continue;
        any = true;
        work(case_of(map));
    }
    if (any) return;
    for (const auto& [width, height] : sizes) work(made_up_case(width, height));
}

void emit(const Bench& bench, const std::string& experiment, Row row) {
    row.experiment = experiment;
    bench.emit(std::move(row));
}

// Returns the parameters of sections 6.2 and 6.3, with SSR and CRR, which the text does not give,
// as in section 6.4.
Config wide_config(const Bench& bench) {
    Config config = bench.options.paper;
    config.sigma_init = kSigma;
    config.ssr = 4;
    return config;
}

// Section 6.1, Fig. 8.
void memory(Bench& bench) {
    for_each_case(
        bench, {"tsukuba", "venus", "teddy", "cones", "conesM", "conesL"},
        {{450, 375}, {900, 750}, {1800, 1500}}, [&](const Case& c) {
            Config config = wide_config(bench);
            config.kernels = Kernels::single;
            config.block_single = 32;
            config.time_kernels = true;
            for (const Memory version : {Memory::version1, Memory::version2, Memory::version2_texture}) {
                config.memory = version;
                emit(bench, "memory", bench.solvers.paper(c, config, bench.options.sweep_runs));
            }
            emit(bench, "memory",
                 bench.solvers.ours(c, "hexrelief", same_schedule(config), bench.options.runs));
        });
}

void keep_fastest(Bench& bench, int co, int block, const Row& row, std::map<std::string, double>& least) {
    for (const auto& [kernel, times] : row.kernels) {
        const auto [at, fresh] = least.try_emplace(kernel, times.median());
        if (!fresh && at->second <= times.median()) continue;
        at->second = times.median();
        bench.fastest[{co, kernel}] = block;
    }
}

// Section 6.2, Fig. 9. Rows are shown if `show` is set.
void sweep_blocks(Bench& bench, const Case& c, int runs, bool show) {
    for (const int co : {10, 20, 30}) {
        Config config = wide_config(bench);
        config.co = co;
        config.time_kernels = true;
        std::map<std::string, double> least;
        for (const Kernels kernels : {Kernels::single, Kernels::multiple})
            for (const int block : kBlocks) {
                config.kernels = kernels;
                set_block(config, block);
                const Row row = bench.solvers.paper(c, config, runs);
                keep_fastest(bench, co, block, row, least);
                if (show) emit(bench, "blocks", row);
            }
    }
}

void blocks(Bench& bench) {
    for_each_case(bench, {"conesM"}, {{900, 750}},
                  [&](const Case& c) { sweep_blocks(bench, c, bench.options.sweep_runs, true); });
}

// Section 6.2, Fig. 10: the two versions, each kernel with its fastest block.
void kernels(Bench& bench) {
    for_each_case(bench, {"conesM"}, {{900, 750}}, [&](const Case& c) {
        if (bench.fastest.empty()) sweep_blocks(bench, c, 1, false);
        for (const int co : {10, 20, 30}) {
            Config config = wide_config(bench);
            config.co = co;
            config.time_kernels = true;
            config.block_single = bench.fastest.at({co, "single"});
            config.block_extraction = bench.fastest.at({co, "extraction"});
            config.block_search = bench.fastest.at({co, "search"});
            config.block_learning = bench.fastest.at({co, "learning"});
            for (const Kernels version : {Kernels::single, Kernels::multiple}) {
                config.kernels = version;
                emit(bench, "kernels", bench.solvers.paper(c, config, bench.options.sweep_runs));
            }
            emit(bench, "kernels",
                 bench.solvers.ours(c, "hexrelief", same_schedule(config), bench.options.runs));
        }
    });
}

// Section 6.3, Fig. 11.
void tradeoff(Bench& bench) {
    for_each_case(
        bench, {"cones", "conesM", "conesL"}, {{450, 375}, {900, 750}, {1800, 1500}}, [&](const Case& c) {
            for (const int ssr : {2, 3, 4, 5, 10, 0})
                for (const int crr : {1, 10, 20, 30, 40, 50, 100}) {
                    Config config = wide_config(bench);
                    config.ssr = ssr;
                    config.crr = crr;
                    const int runs = bench.options.sweep_runs;
                    emit(bench, "tradeoff", bench.solvers.paper(c, config, runs));
                    emit(bench, "tradeoff", bench.solvers.ours(c, "hexrelief", same_schedule(config), runs));
                }
        });
}

// Section 6.3, Fig. 12.
void iterations(Bench& bench) {
    for_each_case(bench, {"cones", "conesM", "conesL", "teddy", "teddyM", "teddyL"},
                  {{450, 375}, {900, 750}, {1800, 1500}}, [&](const Case& c) {
                      for (int t_max = 100; t_max <= 1500; t_max += 100) {
                          Config config = wide_config(bench);
                          config.t_max = t_max;
                          const int runs = bench.options.sweep_runs;
                          emit(bench, "iterations", bench.solvers.paper(c, config, runs));
                          emit(bench, "iterations",
                               bench.solvers.ours(c, "hexrelief", same_schedule(config), runs));
                      }
                  });
}

// Measures one size with all programs; those that do not fit into the device's memory are named and left out.
std::vector<Row> size_rows(const Bench& bench, const Case& c, int ssr) {
    const long long pixels = static_cast<long long>(c.density.width) * c.density.height;
    const int runs = bench.options.runs, few = pixels > kManyPixels ? bench.options.sweep_runs : runs;
    Config config = bench.options.paper;
    config.ssr = ssr;
    MeshConfig som, balanced;
    som.balance.enabled = false;
    std::vector<Row> rows;
    const auto attempt = [&](const char* solver, const auto& solve) {
        try {
            rows.push_back(solve());
            emit(bench, "size", rows.back());
        } catch (const Error& error) {
            bench.note("left out: " + c.map + " " + std::to_string(c.density.width) + "x" +
                       std::to_string(c.density.height) + " " + solver + ": " + error.what());
        }
    };
    attempt("paper", [&] { return bench.solvers.paper(c, config, few); });
    bench.solvers.release();
    attempt("hexrelief", [&] { return bench.solvers.ours(c, "hexrelief", same_schedule(config), few); });
    attempt("default", [&] { return bench.solvers.ours(c, "default", som, runs); });
    if (pixels <= kMostCpuPixels) {
        attempt("balanced", [&] { return bench.solvers.ours(c, "balanced", balanced, few); });
        attempt("som", [&] { return bench.solvers.ours(c, "som", som_config(), few); });
        attempt("cut", [&] { return bench.solvers.cut_mesh(c, few); });
        attempt("cpu", [&] { return bench.solvers.on_cpu(c, same_schedule(config)); });
    }
    return rows;
}

// Section 6.4, Fig. 13: the paper's maps, then the scene from small to very large.
void size(Bench& bench) {
    for (const FoundMap& found : bench.found) size_rows(bench, case_of(found), found.map.ssr);
    std::vector<std::pair<int, int>> sizes{{450, 375}, {900, 750}, {1800, 1500}};
    for (int side = 2048; side <= bench.options.largest; side *= 2) sizes.emplace_back(side, side);
    std::map<std::string, double> reference;  // ns/px at 1800x1500
    for (const auto& [width, height] : sizes)
        for (const Row& row : size_rows(bench, made_up_case(width, height), 4)) {
            if (row.som_s.empty()) continue;
            if (width == 1800) reference[row.solver] = row.nanoseconds_per_pixel();
            if (row.width <= 1800 || !reference.contains(row.solver)) continue;
            char text[160];
            std::snprintf(text, sizeof text, "%dx%d by %s: %.2f times the SOM's cost per pixel of 1800x1500",
                          row.width, row.height, row.solver.c_str(),
                          row.nanoseconds_per_pixel() / reference[row.solver]);
            bench.note(text);
        }
}

const std::vector<std::pair<std::string, void (*)(Bench&)>> kExperiments{
    {"memory", memory},     {"blocks", blocks},         {"kernels", kernels},
    {"tradeoff", tradeoff}, {"iterations", iterations}, {"size", size}};

}  // namespace

const std::vector<std::string>& experiment_names() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> all;
        for (const auto& [name, work] : kExperiments) all.push_back(name);
        return all;
    }();
    return names;
}

void run_experiment(Bench& bench, const std::string& name) {
    for (const auto& [known, work] : kExperiments)
        if (known == name) work(bench);
}

}  // namespace hexrelief::paper
