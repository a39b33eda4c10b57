// `hexrelief bench match`: quality and time of the disparity stage by each matcher, on pairs with ground
// truth.
#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

#include "pipeline/bench/match/match_scenes.h"

namespace hexrelief::bench {

struct MatchOptions {
    std::filesystem::path data;         // a folder of scenes, at any depth: match_scenes.h
    std::vector<std::string> scenes;    // by the names of their folders; empty = all
    std::vector<std::string> methods;   // empty = all
    std::vector<std::string> settings;  // "key.path=value", for every method
    match::Disturbance disturbance;
    int runs = 3;                                   // timed runs of each method
    int threads = 0;                                // 0 = all that the process may use
    std::filesystem::path json;                     // also written there; empty = not
    std::function<void(const std::string&)> warns;  // of settings by their older names; may be empty
};

// Writes the rows to `out` as they come, then the means. Throws Error: usage for a name that is not known or
// a number out of range, input where a scene cannot be read or the folder has none, output where the JSON
// file cannot be written.
void run_bench_match(const MatchOptions& options, std::ostream& out);

}  // namespace hexrelief::bench
