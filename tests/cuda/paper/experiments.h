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
    // Settings of the paper baseline, for experiments that do not vary them:
    std::string kernels = "single";  // or "multiple"
    std::string memory = "2";        // or "1", "2-texture": Fig. 7
    int block = 8;                   // threads of a block; 8 is the paper's fastest with co 20

    int threads = 0;             // of the CPU backend and of measuring quality; 0 = all
    std::filesystem::path json;  // the results as JSON; empty = not written
};

// The input and output of the experiments.
struct Bench {
    const BenchOptions& options;
    const std::vector<FoundMap>& found;  // empty = the synthetic scene is used instead
    paper::Config paper;                 // for experiments that do not vary it
    Solvers& solvers;
    std::function<void(Row)> emit;                       // receives each row as it is measured
    std::function<void(const std::string&)> note;        // receives a line for people
    std::map<std::pair<int, std::string>, int> fastest;  // fastest block of (co, kernel), found by `blocks`
};

// Returns the experiments' names in the paper's order.
const std::vector<std::string>& experiment_names();

// Runs one experiment. Throws what run() throws.
void run_experiment(Bench& bench, const std::string& name);

}  // namespace hexrelief::paper
