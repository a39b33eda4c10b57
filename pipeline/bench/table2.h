// `hexrelief bench table2`: the paper's Table 2 for those of its maps that a folder holds, by all methods and
// on all usable backends.
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
    int runs = 3;                   // timed runs of each method, all with the same seed; >= 1
    int sequential_runs = 0;        // of the sequential method; 0 = `runs` on small maps, one on the others
    int threads = 0;                // of the CPU backend; 0 = all that the process may use
    std::filesystem::path json;     // the results as JSON; empty = not written
    std::vector<std::string> maps;  // the paper's names; empty = all that are in the folder
    std::vector<std::string> methods;   // "sequential", "paper", "som", "default"; empty = all
    std::vector<std::string> settings;  // "key.path=value": density.* and mesh.* of the default method
};

// Writes the table to `out`, each row as it is measured. Throws Error(usage) for an unknown name or
// setting, Error(input) if `data` holds none of the maps or a map cannot be read, Error(output) if the JSON
// file cannot be written.
void run_bench_table2(const Table2Options& options, std::ostream& out);

// Returns the mesh configuration of a method other than the default. ssr: the value that the paper
// uses for the map.
MeshConfig method_config(const std::string& method, int ssr);

// Returns the paper's density, as in config/paper.yaml.
stages::DensityConfig paper_density();

}  // namespace hexrelief::bench
