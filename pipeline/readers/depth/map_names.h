// The names by which the map is found in files that hold several arrays or channels.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pipeline/readers/source.h"

namespace hexrelief::readers::codec {

// Returns the index of the most usual name for what is wanted; nullopt if none is usual. A name of several
// parts, "layer.channel", counts by its last part ("View.Z") or by its layer ("depth.R"), but a whole name
// counts more, and the z of a vector ("N.Z" beside "N.X") not at all.
std::optional<std::size_t> usual_name(const std::vector<std::string>& names, Wanted wanted);

}  // namespace hexrelief::readers::codec
