// Checks whether a calibration is plausible, a map holds disparities in px, and the picture is that of its
// view; whether a pair is rectified, left and right are not exchanged, and the range contains its
// disparities.
#pragma once

#include <vector>

#include "pipeline/checks/map_statistics.h"
#include "pipeline/checks/thresholds.h"
#include "pipeline/data/calibration.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/stages/disparity_range.h"

namespace hexrelief::checks {

// Checks a metric calibration; others are not judged. median_disparity_px: of the scene; NaN if unknown.
std::vector<Finding> check_camera(const Calibration& camera, double median_disparity_px);
// As check_camera(), for a depth map, whose depths are in metres whatever baseline its
// disparities were made with.
std::vector<Finding> check_depths(const Calibration& camera, double median_disparity_px);

// Checks the angle of view, whether the calibration is metric or not: a focal length in mm is a wide one.
std::vector<Finding> check_focal(const Calibration& camera);

enum class MapKind { disparity, depth };

// Returns what seems to be wrong with a map. left: the picture of the same view and size, or empty. For a
// depth map, `map` holds the disparities made from it, whose scale is not judged.
std::vector<Finding> check_map(const DisparityMap& map, const Image& left, MapKind kind = MapKind::disparity,
                               const MapScale& stored = {});

// Returns the likely mistakes in a pair; if one mistake explains several findings, only that one. Empty for a
// right pair. coarse: from match_coarsely(pair, ...), starting at range.min_px or below. A range that the
// program chose is not judged. seen_share: of the right view, as agreed_share() takes it. The result is the
// same for any number of threads.
std::vector<Finding> check_pair(const StereoPair& pair, const stages::SmallMatch& coarse,
                                const matching::DisparityRange& range, stages::RangeOrigin origin,
                                double seen_share, int threads);

}  // namespace hexrelief::checks
