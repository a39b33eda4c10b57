// The rows of `bench_paper`.
#pragma once

#include <algorithm>
#include <limits>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tests/cuda/paper/som.h"

namespace hexrelief::paper {

// Seconds of several runs, in any order. Without a run each figure is NaN.
struct Times {
    std::vector<double> runs;

    bool empty() const { return runs.empty(); }
    double median() const {
        if (empty()) return std::numeric_limits<double>::quiet_NaN();
        std::vector<double> sorted = runs;
        std::sort(sorted.begin(), sorted.end());
        return 0.5 * (sorted[(sorted.size() - 1) / 2] + sorted[sorted.size() / 2]);
    }
    double least() const { return empty() ? median() : *std::min_element(runs.begin(), runs.end()); }
    double most() const { return empty() ? median() : *std::max_element(runs.begin(), runs.end()); }
};

struct Row {
    std::string experiment, map;
    std::string solver;  // "paper" (the paper baseline), "hexrelief" (ours with its schedule), "default", ...
    std::optional<Config> baseline = {};        // of the paper baseline only
    std::map<std::string, Times> kernels = {};  // of its kernels: sums over a run's iterations, if timed
    long long escaped = 0;                      // vertices that left the image

    int width = 0, height = 0, columns = 0, rows = 0, co = 0, ssr = 0, crr = 0, iterations = 0;
    double sigma_init = 0;
    Times som_s;    // on the device's clock
    Times stage_s;  // on the host's, transfers included
    double percent_cost = std::numeric_limits<double>::quiet_NaN();
    long long inverted = 0;
    std::size_t device_bytes = 0;

    double nanoseconds_per_pixel() const { return som_s.median() * 1e9 / width / height; }
};

// The names of values of Kernels and of Memory, in their order.
inline constexpr const char *kKernelsNames[] = {"single", "multiple"},
                            *kMemoryNames[] = {"1", "2", "2-texture"};

// Returns the row as JSON; fields that do not apply are left out.
nlohmann::ordered_json row_json(const Row& row);

}  // namespace hexrelief::paper
