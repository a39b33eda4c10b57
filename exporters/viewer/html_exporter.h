// Exports a page that shows the relief in a browser: a single file that loads nothing else.
#pragma once

#include "exporters/core/format_writer.h"

namespace hexrelief::exporters {

// False if the program was built without node.js and npm; write_html() then throws an Error
// with the text kNoViewer.
bool has_viewer();
inline constexpr const char* kNoViewer =
    "this hexrelief was built without its viewer; install nodejs and npm and build it again, or write .glb";

// Writes the page. The scene needs a camera and the size of its image. Whatever `config` says, the page
// holds the mesh as a GLB with EXT_meshopt_compression, in all levels of detail and without normals; its
// tolerance may be finer than the configured one. The texture is as configured. The page's title is the
// path's stem. Throws Error(output).
void write_html(const Scene& scene, const ExportConfig& config, const std::filesystem::path& path,
                FileTransaction& files);

}  // namespace hexrelief::exporters
