// The results of a run in words.
#pragma once

#include <hexrelief/run.h>

#include <cstdint>
#include <string>

namespace hexrelief::cli {

// Returns "1 234 567".
std::string grouped(std::uint64_t value);

// Returns the summary: a line each for a budget, a photograph's own camera
// and an alignment if there is one; a line with the files written and their bytes;
// and a line with the mesh, its depths, the share of the picture that it covers, and the shares that it does
// not. `seconds`: the run's time.
std::string summary_text(const RunSummary& run, const FileRequest& request, double seconds);

}  // namespace hexrelief::cli
