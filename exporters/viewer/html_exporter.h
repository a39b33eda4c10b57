// Exports a page that shows the relief in a browser: a single file that loads nothing else.
#pragma once

namespace hexrelief::exporters {

// False if the program was built without node.js and npm; write_html() then throws an Error
// with the text kNoViewer.
bool has_viewer();
inline constexpr const char* kNoViewer =
    "this hexrelief was built without its viewer; install nodejs and npm and build it again, or write .glb";

}  // namespace hexrelief::exporters
