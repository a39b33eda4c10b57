// The pages without their content, as build.mjs makes them.
#pragma once

#include <string_view>

namespace hexrelief::exporters {

// Empty where the program was built without it. Holds "@title@" twice, "@facts@" and "@glb@", in this order,
// where these are to be put in; what follows them is the script.
std::string_view viewer_page();

// The page of a gallery. Holds "@title@" twice, "@columns@" and "@rows@", in this order.
std::string_view empty_gallery();

}  // namespace hexrelief::exporters
