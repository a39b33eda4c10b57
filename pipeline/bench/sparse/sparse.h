// `hexrelief bench sparse`: by how much thinning a map increases the error of the surface made of it.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

namespace hexrelief::bench {

struct SparseOptions {
    std::filesystem::path data;         // a folder of scenes, at any depth: bench/match/match_scenes.h
    std::vector<std::string> scenes;    // names of the scenes' folders; empty = all
    std::vector<std::string> patterns;  // bench/sparse/patterns.h; empty = all
    std::vector<std::string> settings;  // "key.path=value"
    std::string preset = "default";
    bool without_picture = false;  // fill the maps without the left picture
    int threads = 0;               // 0 = all that the process may use
    std::filesystem::path json;    // the results as JSON; empty = not written
};

// Meshes each true map as it is, and again thinned and filled. Both surfaces are measured against the true
// map. Writes each row to `out` as it is measured, then the means of the ratios. Throws Error(usage) for an
// unknown name, Error(input) if a scene cannot be read or the folder has none, Error(output) if the JSON
// file cannot be written.
void run_bench_sparse(const SparseOptions& options, std::ostream& out);

}  // namespace hexrelief::bench
