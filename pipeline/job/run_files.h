// The names of all files that a job reads and writes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "exporters/exporter.h"
#include "pipeline/job/request.h"

namespace hexrelief::job {

// `path` and the files that its format writes beside it (.mtl, .bin, the texture), whether this run needs
// them or not.
std::vector<std::filesystem::path> planned_files(const std::filesystem::path& path,
                                                 const exporters::ExportConfig& config);

// What is told where levels of detail are inside of a file, which not all programs understand; else empty.
std::string levels_inside_warning(const RunRequest& request);

// A rule for make: the outputs depend on all files that the job reads. Throws as make_rule().
std::string depfile_rule(const RunRequest& request);

// "glb:-, drc:-, ...": what sends a format that is one file to the standard output.
std::string standard_output_names();
bool writes_standard_output(const RunRequest& request);

// All that the job may write and read.
std::vector<std::filesystem::path> written_files(const RunRequest& request);
std::vector<std::filesystem::path> read_files(const RunRequest& request);

// The memory that a run takes, in bytes, from the header of the first input and mesh.spacing_px: 40 MiB and,
// at the default of 6 px, 150 bytes a pixel; 300 at 3 px and 550 at 2 px. Pairs and maps of 2000x1500 px took
// 51 bytes, 139 and 270, those of 640x480 at most 96 and 203 (spacing 6 and 2). A budget may find a smaller
// spacing than this is told. 40 MiB where the header cannot be read: such a run fails early.
std::uint64_t estimated_memory(const RunRequest& request);

}  // namespace hexrelief::job
