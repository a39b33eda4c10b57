// What bench_paper is asked for.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace hexrelief::paper {

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

}  // namespace hexrelief::paper
