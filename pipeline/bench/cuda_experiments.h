// The experiments of `hexrelief bench cuda`, by the paper's figures.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/bench/cuda.h"
#include "pipeline/bench/cuda_solvers.h"
#include "pipeline/bench/maps.h"

namespace hexrelief::bench::cuda_bench {

struct Bench {
    const CudaBenchOptions& options;
    const std::vector<FoundMap>& found;  // empty = the made-up scene takes their place
    paper::Config paper;                 // where an experiment does not vary it
    Solvers& solvers;
    std::function<void(Row)> emit;                       // takes each row as it comes
    std::function<void(const std::string&)> note;        // and a line for people
    std::map<std::pair<int, std::string>, int> fastest;  // block of (co, kernel), from `blocks`
};

// Names in the paper's order.
const std::vector<std::string>& experiment_names();

// Throws as run_bench_cuda.
void run_experiment(Bench& bench, const std::string& name);

}  // namespace hexrelief::bench::cuda_bench
