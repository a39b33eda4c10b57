// `hexrelief bench table2`: the paper's Table 2 on those of its maps that a folder holds, by all methods and
// all backends that there are.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

#include "mesher/mesher.h"
#include "pipeline/stages/density.h"

namespace hexrelief::bench {

struct Table2Options {
    std::filesystem::path data;     // Middlebury's maps: middlebury2001/tsukuba/disp.pgm and so on
    int runs = 3;                   // timed runs of each method, the same seed in all; >= 1
    int sequential_runs = 0;        // of the sequential method; 0 = `runs` on small maps, one on the others
    int threads = 0;                // of the CPU backend; 0 = all that the process may use
    std::filesystem::path json;     // also written there; empty = not
    std::vector<std::string> maps;  // by the paper's names; empty = all that are there
    std::vector<std::string> methods;   // "sequential", "paper", "som", "default"; empty = all
    std::vector<std::string> settings;  // "key.path=value": density.* and mesh.* of the default method
};

// Writes the table to `out` row by row, as the rows come. Throws Error: usage for a name or setting that is
// not known, input where `data` holds none of the maps asked for or a map cannot be read, output where the
// JSON file cannot be written.
void run_bench_table2(const Table2Options& options, std::ostream& out);

// The mesh configuration of a method other than the default; ssr: of the paper's, for the map.
MeshConfig method_config(const std::string& method, int ssr);

// The paper's density, as in config/paper.yaml.
stages::DensityConfig paper_density();

}  // namespace hexrelief::bench
