// `hexrelief bench sparse`: what thinning a map costs the surface that is made of it.
#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

namespace hexrelief::bench {

struct SparseOptions {
    std::filesystem::path data;         // a folder of scenes, at any depth: bench/match/match_scenes.h
    std::vector<std::string> scenes;    // by the names of their folders; empty = all
    std::vector<std::string> patterns;  // bench/sparse/patterns.h; empty = all
    std::vector<std::string> settings;  // "key.path=value"
    std::string preset = "default";
    bool without_picture = false;                   // fill the maps without the left picture
    int threads = 0;                                // 0 = all that the process may use
    std::filesystem::path json;                     // also written there; empty = not
    std::function<void(const std::string&)> warns;  // of settings by their older names; may be empty
};

// Each true map is meshed as it is, and again thinned and filled. Both surfaces are measured against the true
// map. Writes the rows to `out` as they come, then the ratios' means. Throws Error: usage for a name that is
// not known, input where a scene cannot be read or the folder has none, output where the JSON file cannot be
// written.
void run_bench_sparse(const SparseOptions& options, std::ostream& out);

}  // namespace hexrelief::bench
