// `hexrelief bench batch`: the number of small jobs per second that a process does, from a pair in memory to
// a GLB in memory.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

namespace hexrelief::bench {

struct BatchOptions {
    std::filesystem::path data;         // a folder of scenes, at any depth: ../match/match_scenes.h
    std::vector<std::string> scenes;    // names of the scenes' folders; empty = all
    std::vector<std::string> settings;  // "key.path=value"
    int jobs = 100;                     // number of timed jobs for each scene on each backend
    int threads = 0;                    // of all workers together; 0 = all that the process may use
    int workers = 0;                    // jobs at a time; 0 = one per thread
    bool files = false;                 // measure from files to files instead: files.h
    std::filesystem::path json;         // the results as JSON; empty = not written
};

// Writes a row for each scene and backend to `out` as it is measured. Throws Error(usage) for an unknown name
// or a number out of range, Error(input) if a scene cannot be read or the folder has none, Error(output) if
// the JSON file cannot be written; std::logic_error if two jobs gave files of different size.
void run_bench_batch(const BatchOptions& options, std::ostream& out);

}  // namespace hexrelief::bench
