// The page templates that build.mjs makes.
#pragma once

#include <string_view>

namespace hexrelief::exporters {

// Returns the viewer's page, empty if the program was built without it. Contains the marks "@title@" (twice),
// "@facts@" and "@glb@", in this order; the script follows them.
std::string_view viewer_page();

// Returns the gallery's page, empty if the program was built without it. Contains the marks "@title@"
// (twice), "@columns@" and "@rows@", in this order.
std::string_view empty_gallery();

}  // namespace hexrelief::exporters
