// `hexrelief bench batch`: how many small jobs a second a process does, from a pair in memory to a GLB in
// memory.
#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

namespace hexrelief::bench {

struct BatchOptions {
    std::filesystem::path data;         // a folder of scenes, at any depth: ../match/match_scenes.h
    std::vector<std::string> scenes;    // by the names of their folders; empty = all
    std::vector<std::string> settings;  // "key.path=value"
    int jobs = 100;                     // timed, of each scene on each backend
    int threads = 0;                    // of all workers together; 0 = all that the process may use
    int workers = 0;                    // jobs at a time; 0 = as many as threads
    bool files = false;                 // from files to files: files.h
    std::filesystem::path json;         // also written there; empty = not
    std::function<void(const std::string&)> warns;  // of settings by their older names; may be empty
};

// Writes a row for each scene and backend to `out` as they come. Throws Error: usage for a name that is not
// known or a number out of range, input where a scene cannot be read or the folder has none, output where the
// JSON file cannot be written; std::logic_error where two jobs gave files of different size.
void run_bench_batch(const BatchOptions& options, std::ostream& out);

}  // namespace hexrelief::bench
