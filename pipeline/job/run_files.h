// The names of all files that a job reads and writes.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "exporters/exporter.h"
#include "pipeline/job/request.h"

namespace hexrelief {

// `path` and the files that its format writes beside it (.mtl, .bin, the texture), whether this run needs
// them or not.
std::vector<std::filesystem::path> planned_files(const std::filesystem::path& path,
                                                 const ExportConfig& config);

// What is told where levels of detail are inside of a file, which not all programs understand; else empty.
std::string levels_inside_warning(const RunRequest& request);

// A rule for make: the outputs depend on all files that the job reads. Each of those has an empty rule of its
// own, so that make goes on where one is no longer there.
std::string depfile_rule(const RunRequest& request);

bool writes_standard_output(const RunRequest& request);

// All that the job may write and read.
std::vector<std::filesystem::path> written_files(const RunRequest& request);
std::vector<std::filesystem::path> read_files(const RunRequest& request);

}  // namespace hexrelief
