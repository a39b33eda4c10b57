// How a known map is thinned, as sensors and matchers that know few pixels leave it.
#pragma once

#include <string>
#include <vector>

#include "pipeline/data/disparity_map.h"

namespace hexrelief::bench::sparse {

// random-20, random-5: that many percent of the pixels. rows-20, rows-5: every 5th or 20th row, whole.
// laser: scan lines some 8 rows apart that wave by 2 rows, with 60 % of their pixels, within 1 row.
const std::vector<std::string>& patterns();

// The same pixels wherever it runs. Throws std::logic_error for a name that is none of patterns().
DisparityMap thinned(const DisparityMap& map, const std::string& pattern);

}  // namespace hexrelief::bench::sparse
