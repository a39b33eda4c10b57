// A pair at half its size.
#pragma once

#include "mesher/common/thread_pool.h"
#include "pipeline/data/image.h"

namespace hexrelief::matching {

// (width + 1) / 2 x (height + 1) / 2 pixels, each the rounded mean of 2x2; the edge is repeated.
Image at_half_size(const Image& image, ThreadPool& pool);

}  // namespace hexrelief::matching
