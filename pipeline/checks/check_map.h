// Checks whether a map holds disparities in px, and whether the picture is that of its view.
#pragma once

#include <vector>

#include "pipeline/checks/finding.h"
#include "pipeline/checks/map_statistics.h"
#include "pipeline/data/disparity_map.h"

namespace hexrelief::checks {

enum class MapKind { disparity, depth };

// Returns what seems to be wrong with a map. left: the picture of the same view and size, or empty. For a
// depth map, `map` holds the disparities made from it, whose scale is not judged.
std::vector<Finding> check_map(const DisparityMap& map, const Image& left, MapKind kind = MapKind::disparity,
                               const MapScale& stored = {});

}  // namespace hexrelief::checks
