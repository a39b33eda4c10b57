// Lists all files that a job reads and writes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "exporters/exporter.h"
#include "pipeline/job/request.h"

namespace hexrelief::job {

// Returns `path` and the files that its format may write beside it (.mtl, .bin, the texture), whether or not
// this run needs them.
std::vector<std::filesystem::path> planned_files(const std::filesystem::path& path,
                                                 const exporters::ExportConfig& config);

// Returns a warning if a file holds its levels of detail inside, which not all
// programs understand; else empty.
std::string levels_inside_warning(const RunRequest& request);

// Returns a rule for make by which the outputs depend on all files that the job reads. Throws as make_rule().
std::string depfile_rule(const RunRequest& request);

// Returns "glb:-, drc:-, ...", the output names that send a single-file format to the standard output.
std::string standard_output_names();
bool writes_standard_output(const RunRequest& request);

// A file that a job may write.
struct WrittenFile {
    std::filesystem::path path;
    std::string purpose;        // for messages
    bool is_texture = false;    // two outputs may share a texture, whose bytes are equal
    bool is_rectified = false;  // one of rectified_file_names(): only a pair that is not yet rectified has it
};

// Returns all files that the job may write, without the standard output.
std::vector<WrittenFile> written_files(const RunRequest& request);
// Returns the files that the outputs' bytes depend on: the source's and those that are named by keys of the
// configuration, whose role is the key's section ("calibration").
std::vector<InputFile> input_files(const RunRequest& request);
// Returns all files that the job reads: input_files() and the configuration itself.
std::vector<std::filesystem::path> read_files(const RunRequest& request);

// Estimates the memory of a run, in bytes, from the header of the first input and mesh.spacing_px: 40 MiB
// plus 150 bytes per pixel at the default spacing of 6 px, 300 at 3 px and 550 at 2 px. Pairs and maps of
// 2000x1500 px took 51, 139 and 270 bytes per pixel, those of 640x480 px at most 96 at 6 px and 203 at 2 px.
// A budget may choose a smaller spacing than the estimate assumes. Returns 40 MiB if the header cannot be
// read: such a run fails early.
std::uint64_t estimated_memory(const RunRequest& request);

}  // namespace hexrelief::job
