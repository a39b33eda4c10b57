// Finds the dark strips that rectifying leaves along a picture's sides.
#pragma once

#include "pipeline/data/image.h"
#include "pipeline/readers/depth/mask_reader.h"

namespace hexrelief::job {

// Returns a mask that keeps all pixels but those of dark strips; empty = there are none. A strip is plain and
// nearly black, runs along the whole of a side, at most a quarter of the picture wide, and ends at a smooth
// line where the picture becomes brighter at once; or it is a wedge from a corner, as a turned picture has.
// Rows and columns that are dark from end to end belong to the strips along the other two sides, and a
// picture with many others that are dark has no strips.
readers::PixelMask without_dark_strips(const Image& image);

}  // namespace hexrelief::job
