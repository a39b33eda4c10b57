// `hexrelief bench rd`: rate and distortion. Bytes against error for the program's presets and for other ways
// to make a mesh of a disparity map, on Middlebury's maps.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

namespace hexrelief::bench {

struct RdOptions {
    std::filesystem::path data;        // Middlebury's maps, as for table2.h
    std::vector<std::string> maps;     // the paper's names; empty = its small and its largest maps
    std::vector<std::string> methods;  // presets and other meshers; empty = all
    // "NAME=DIR": meshes of other programs (rd_peers.h), compared with the chosen methods
    std::vector<std::string> peers;
    std::vector<double> spacings{4, 5, 6, 7.5, 9, 10, 12, 15, 18};  // px, of lattices and uniform grids
    std::vector<std::string> settings;  // "key.path=value", on top of every preset
    int threads = 0;                    // 0 = all that the process may use
    std::filesystem::path json;         // the results as JSON; empty = not written
};

// Writes the tables to `out` as they are measured. Every mesh is reduced to positions (x, y and disparity in
// px), compressed by Draco at level 7 and measured as decoded. Positions are quantised to 12 bits in other
// meshers' meshes, to 10 and to 12 bits in peers' files, and to tolerance_px in those of presets. A peer may
// have files of many kinds: in the comparison of all methods only those count that no other one beats in both
// bytes and error. Throws Error(usage) for an unknown name or spacings out of range, Error(input) if a map or
// a peer's file cannot be read, Error(output) if the JSON file cannot be written.
void run_bench_rd(const RdOptions& options, std::ostream& out);

}  // namespace hexrelief::bench
