// `hexrelief bench match`: quality and time of the disparity stage with each matcher, on
// pairs with ground truth.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

#include "pipeline/bench/match/match_scenes.h"

namespace hexrelief::bench {

struct MatchOptions {
    std::filesystem::path data;         // a folder of scenes, at any depth: match_scenes.h
    std::vector<std::string> scenes;    // names of the scenes' folders; empty = all
    std::vector<std::string> methods;   // empty = all
    std::vector<std::string> settings;  // "key.path=value", for every method
    match::Disturbance disturbance;
    int runs = 3;                // timed runs of each method
    int threads = 0;             // 0 = all that the process may use
    std::filesystem::path json;  // the results as JSON; empty = not written
};

// Writes each row to `out` as it is measured, then the means. Throws Error(usage) for an unknown name or a
// number out of range, Error(input) if a scene cannot be read or the folder has none, Error(output) if the
// JSON file cannot be written.
void run_bench_match(const MatchOptions& options, std::ostream& out);

}  // namespace hexrelief::bench
