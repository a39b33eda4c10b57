// Continues the matched surfaces of a photograph over large parts without matches along its rims.
#pragma once

#include "pipeline/data/disparity_map.h"
#include "pipeline/data/image.h"

namespace hexrelief::stages {

// Filling pixel by pixel leaves shreds and pits where nothing matched over more than a 20th of the longer
// side. Within a tenth of it from the end of what is known they are seen against nothing. Filled pixels there
// lie no nearer than the plane through the surely matched ones around them, which count the more the fewer
// colours lie between; the plane departs from their mean by twice their standard deviation at most. What a
// nearer surface hides from the right camera stays. left: the picture of the map's view and size. Maps
// without origins, unknown pixels and origins stay. The same for any number of threads.
DisparityMap with_unmatched_parts_continued(DisparityMap map, const Image& left, int threads);

}  // namespace hexrelief::stages
