// `hexrelief bench rd`: rate and distortion. Bytes against error for the program's presets and for other ways
// to make a mesh of a disparity map, on Middlebury's maps.
#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

namespace hexrelief::bench {

struct RdOptions {
    std::filesystem::path data;        // Middlebury's maps, as for table2.h
    std::vector<std::string> maps;     // by the paper's names; empty = its small and its largest ones
    std::vector<std::string> methods;  // of presets and other meshers; empty = all
    // "NAME=DIR": meshes of other programs (rd_peers.h), compared with whatever methods are asked for
    std::vector<std::string> peers;
    std::vector<double> spacings{4, 5, 6, 7.5, 9, 10, 12, 15, 18};  // px, of lattices and uniform grids
    std::vector<std::string> settings;              // "key.path=value", on top of every preset
    int threads = 0;                                // 0 = all that the process may use
    std::filesystem::path json;                     // also written there; empty = not
    std::function<void(const std::string&)> warns;  // told of settings by old names; may be empty
};

// Writes the tables to `out` as they come. Every mesh holds positions alone, x, y and disparity in px, is
// compressed by Draco at level 7 and measured as decoded. Other meshers' meshes are quantised to 12 bits,
// peers' files to 10 and to 12 bits, those of presets to tolerance_px. A peer's files may be of many kinds:
// where all are compared, those count that no other beats in both bytes and error. Throws Error: usage for a
// name that is not known or spacings out of range, input where a map or a peer's file cannot be read, output
// where the JSON file cannot be written.
void run_bench_rd(const RdOptions& options, std::ostream& out);

}  // namespace hexrelief::bench
