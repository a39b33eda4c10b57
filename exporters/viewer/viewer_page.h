// The page without a scene, as build.mjs makes it.
#pragma once

#include <string_view>

namespace hexrelief {

// Empty where the program was built without it. Holds "@title@" twice, "@facts@" and "@glb@", in this order,
// where these are to be put in; what follows them is the script.
std::string_view viewer_page();

}  // namespace hexrelief
