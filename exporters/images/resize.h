// Resizes images.
#pragma once

#include "pipeline/data/image.h"

namespace hexrelief::exporters {

// Returns the image at another size: each pixel is the mean over the area of `image` that it covers. Sides
// are at least 1 px.
Image resized(const Image& image, int width, int height, int threads = 1);

}  // namespace hexrelief::exporters
