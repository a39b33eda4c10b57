// Is it a disparity map in px, and is the picture that of its view?
#pragma once

#include <vector>

#include "pipeline/checks/finding.h"
#include "pipeline/checks/map_statistics.h"
#include "pipeline/data/disparity_map.h"

namespace hexrelief::checks {

enum class MapKind { disparity, depth };

// What a map that was read seems to be wrong in; left: the picture of the same view and size, or empty. Of a
// depth map the disparities that were made from it, whose scale is then not judged.
std::vector<Finding> check_map(const DisparityMap& map, const Image& left, MapKind kind = MapKind::disparity,
                               const MapScale& stored = {});

}  // namespace hexrelief::checks
