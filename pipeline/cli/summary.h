// What a run came to, in words.
#pragma once

#include <hexrelief/run.h>

#include <cstdint>
#include <string>

namespace hexrelief::cli {

// "1 234 567"
std::string grouped(std::uint64_t value);

// Two lines, after one for a budget: the files written with their bytes; the mesh, its depths, how much of
// the picture it covers, and what share of the map is none of the scene. `seconds` are the run's.
std::string summary_text(const RunSummary& run, const FileRequest& request, double seconds);

}  // namespace hexrelief::cli
