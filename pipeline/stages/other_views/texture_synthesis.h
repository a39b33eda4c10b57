// The texture of what continues behind silhouettes.
#pragma once

#include "pipeline/base/thread_pool.h"
#include "pipeline/data/image.h"
#include "pipeline/stages/other_views/continued.h"

namespace hexrelief::stages {

// Returns a picture of a view, at any size, in which what continues has the texture of the surface that it
// continues, from coarse to fine cells: each square of cells is like one of the squares in which the picture
// shows that surface, and which fit what is beside it (as in Wexler et al. 2007, Barnes et al. 2009). Removes
// what is painted from `continued`; for the rest there is no such square. front: the disparities of the view.
// The same for any number of threads.
Image with_texture(const Image& seen, const ViewPlace& place, Continued& continued, const Disparities& front,
                   ThreadPool& pool);

}  // namespace hexrelief::stages
