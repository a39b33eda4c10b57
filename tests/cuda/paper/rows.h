// The rows of `bench_paper`, as text and as JSON.
#pragma once

#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "tests/cuda/paper/text.h"

namespace hexrelief::paper {

struct Row {
    std::string experiment, map;
    std::string solver;  // "paper" (the paper baseline), "hexrelief" (ours with its schedule), "default", ...
    // For the paper baseline only, else empty or 0.
    std::string kernels, memory;
    int block_single = 0, block_extraction = 0, block_search = 0, block_learning = 0;
    Times single_s, extraction_s, search_s, learning_s;  // sums over a run's iterations; empty = not timed
    long long escaped = 0;                               // vertices that left the image

    int width = 0, height = 0, columns = 0, rows = 0, co = 0, ssr = 0, crr = 0, iterations = 0;
    double sigma_init = 0;
    Times som_s;    // on the device's clock
    Times stage_s;  // on the host's, transfers included
    double percent_cost = std::numeric_limits<double>::quiet_NaN();
    long long inverted = 0;
    std::size_t device_bytes = 0;

    double nanoseconds_per_pixel() const { return som_s.median() * 1e9 / width / height; }
};

// Returns the two lines above the rows.
std::string headings();
// Returns one line, with its line feed.
std::string row_text(const Row& row);
// Returns the row as JSON; fields that do not apply are left out.
nlohmann::ordered_json row_json(const Row& row);

}  // namespace hexrelief::paper
