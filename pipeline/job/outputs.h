// Writes the files of a run.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "exporters/core/scene.h"
#include "pipeline/files/output_set.h"
#include "pipeline/job/input.h"
#include "pipeline/job/relief.h"
#include "pipeline/stages/surface_quality.h"

namespace hexrelief::job {

struct OutputFile {
    std::string path;
    std::string format;  // "glb", "obj", "mtl", "jpg", ...
    std::uint64_t bytes = 0;
    std::string sha256;
};

// Returns the exporters' input, which refers to the arguments.
exporters::Scene scene_of(const LeftView& view, const SurfaceResult& result,
                          const std::vector<SurfaceMesh>& coarser);

// True if a file at this path has quantised positions.
bool is_compressed(const std::filesystem::path& path, const exporters::ExportConfig& config);

// Returns the scene's mesh with the triangles, image points and disparities that a reader of the first
// compressed one of `outputs` gets; the mesh itself if no output is compressed. The scene has a camera, and
// all positions lie in front of it.
SurfaceMesh as_written(const exporters::Scene& scene, const exporters::ExportConfig& config,
                       const std::vector<std::filesystem::path>& outputs);

// Measures the left view's part of the surface, as the compressed files among `outputs` hold it, against the
// map. Takes as long as a good part of the stage surface.
stages::SurfaceQuality quality_as_written(const LeftView& view, const SurfaceResult& result,
                                          const std::vector<std::filesystem::path>& outputs, int threads);
void tell_quality(const stages::SurfaceQuality& quality, const RunLog& log);

// Writes each of `paths` with its companion files; makes missing folders. Throws Error(output).
std::vector<OutputFile> export_all(const exporters::Scene& scene, const exporters::ExportConfig& config,
                                   const std::vector<std::filesystem::path>& paths, files::OutputSet& files,
                                   const RunLog& log);

// Writes data and pictures of all stages. Throws Error(output).
void save_stages(const LeftView& view, const SurfaceResult& result, const std::filesystem::path& folder,
                 files::OutputSet& files, int threads, const RunLog& log);

// Writes a rectified pair, and its camera as a file that --calib reads. Throws Error(output).
void save_rectified(const StereoPair& pair, const Calibration& camera, const std::filesystem::path& folder,
                    files::OutputSet& files);

// True if one of the outputs is a page.
bool has_page(const std::vector<std::filesystem::path>& outputs);

exporters::PageContent page_content(const LeftView& view, const SurfaceResult& result,
                                    const stages::SurfaceQuality& quality, int threads);

}  // namespace hexrelief::job
