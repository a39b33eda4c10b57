// Whether pages that show the relief in a browser can be written.
#pragma once

namespace hexrelief {

// False where the program was built without node.js and npm: then writing a page throws, with
// kNoViewer's words.
bool has_viewer();
inline constexpr const char* kNoViewer =
    "this hexrelief was built without its viewer; install nodejs and npm and build it again, or write .glb";

}  // namespace hexrelief
