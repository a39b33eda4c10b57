// Reduces pictures to half their size.
#pragma once

#include "pipeline/base/thread_pool.h"
#include "pipeline/data/image.h"

namespace hexrelief::matching {

// Returns a picture of (width + 1) / 2 x (height + 1) / 2 pixels, each the rounded mean of 2x2 pixels;
// the edge is repeated.
Image at_half_size(const Image& image, ThreadPool& pool);

}  // namespace hexrelief::matching
