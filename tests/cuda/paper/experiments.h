// The experiments of `bench_paper`, one for each of the paper's figures.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tests/cuda/paper/maps.h"
#include "tests/cuda/paper/solvers.h"

namespace hexrelief::paper {

// What bench_paper is asked for.
struct BenchOptions {
    std::filesystem::path data;            // Middlebury's maps; empty = a synthetic scene
    std::vector<std::string> experiments;  // names from experiment_names(); empty = all
    int runs = 20;                         // timed runs of each row; medians are shown
    int sweep_runs = 3;   // the same for the paper baseline outside `size`, for sweeps, and above 2^24 px
    int largest = 16384;  // side of the largest synthetic map of `size`, px
    Config paper;         // of the paper baseline, for experiments that do not vary it

    int threads = 0;             // of the CPU backend and of measuring quality; 0 = all
    std::filesystem::path json;  // the results as JSON; empty = not written
};

// The input and output of the experiments.
struct Bench {
    const BenchOptions& options;
    const std::vector<FoundMap>& found;  // empty = the synthetic scene is used instead
    Solvers& solvers;
    std::function<void(Row)> emit;                       // receives each row as it is measured
    std::function<void(const std::string&)> note;        // receives a line for people
    std::map<std::pair<int, std::string>, int> fastest;  // fastest block of (co, kernel), found by `blocks`
};

// Sets the threads of a block of all kernels.
inline void set_block(Config& config, int block) {
    config.block_single = config.block_extraction = config.block_search = config.block_learning = block;
}

// Returns the experiments' names in the paper's order.
const std::vector<std::string>& experiment_names();

// Runs one experiment. Throws what run() throws.
void run_experiment(Bench& bench, const std::string& name);

}  // namespace hexrelief::paper
