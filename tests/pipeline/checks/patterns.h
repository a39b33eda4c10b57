// Patterns by which a known map is thinned, like those of sensors and matchers that know few pixels.
#pragma once

#include <string>
#include <vector>

#include "pipeline/data/disparity_map.h"

namespace hexrelief::checks {

// Returns the patterns' names. random-20, random-5: that many percent of the pixels. rows-20, rows-5:
// every 5th or 20th row. laser: scan lines 8 rows apart that wave by 2 rows and jitter by 1 row, with 60
// % of their pixels.
const std::vector<std::string>& patterns();

// Returns the thinned map; the pixels are the same on every machine. Throws std::logic_error for a name that
// is not one of patterns().
DisparityMap thinned(const DisparityMap& map, const std::string& pattern);

}  // namespace hexrelief::checks
