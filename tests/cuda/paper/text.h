// Times, and text as by printf().
#pragma once

#include <algorithm>
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

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

// Cut off after 511 bytes.
std::string format(const char* pattern, auto... values) {
    char text[512];
    std::snprintf(text, sizeof text, pattern, values...);
    return text;
}

}  // namespace hexrelief::paper
