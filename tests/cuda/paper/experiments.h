// The experiments of `bench_paper`, one for each of the paper's figures.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tests/cuda/paper/maps.h"
#include "tests/cuda/paper/options.h"
#include "tests/cuda/paper/solvers.h"

namespace hexrelief::paper {

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
