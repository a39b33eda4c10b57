// A page that shows the relief in a browser: one file, which asks nobody for anything.
#pragma once

#include "exporters/core/format_writer.h"

namespace hexrelief {

// False where the program was built without node.js and npm: then write_html() throws, with kNoViewer's
// words.
bool has_viewer();
inline constexpr const char* kNoViewer =
    "this hexrelief was built without its viewer; install nodejs and npm and build it again, or write .glb";

// The tolerance of a page's positions, px: finer than config.tolerance_px where that costs few bytes.
// config's normals are decided, as for write_html(). path names the page in messages.
double page_tolerance_px(const Scene& scene, const ExportConfig& config, const std::filesystem::path& path);

// The scene needs a camera and the size of its image. The mesh is in the page as a GLB with
// EXT_meshopt_compression, in all levels of detail, without normals, whatever config says of these, and
// within page_tolerance_px(); its texture is as config asks. The page's title is path's stem. Throws
// Error(output).
void write_html(const Scene& scene, const ExportConfig& config, const std::filesystem::path& path,
                FileTransaction& files);

}  // namespace hexrelief
