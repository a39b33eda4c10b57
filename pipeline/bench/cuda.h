// `hexrelief bench cuda`: the paper's GPU experiments (sections 6.1 to 6.4), with the paper baseline (the
// program that the paper describes) and with ours, on the same device.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

namespace hexrelief::bench {

struct CudaBenchOptions {
    std::filesystem::path data;            // Middlebury's maps, as for table2.h; empty = a synthetic scene
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

// Writes the table to `out`, each row as it is measured. Throws Error(device) if no CUDA device is usable,
// Error(usage) for an unknown name, Error(input) if `data` holds none of the maps, Error(output) if the JSON
// file cannot be written.
void run_bench_cuda(const CudaBenchOptions& options, std::ostream& out);

}  // namespace hexrelief::bench
