// Makes what the left camera does not see part of a surface (pipeline/stages/other_views).
#pragma once

#include "pipeline/job/input.h"
#include "pipeline/job/relief.h"

namespace hexrelief::job {

// Adds to the left view's surface what only the right camera sees, and what no camera saw behind silhouettes,
// with a texture of all of it.
void add_other_views(SurfaceResult& result, const LeftView& view, const config::Config& config, int threads,
                     const RunLog& log);

// Adds the same to a coarser level of that surface.
void add_other_views(SurfaceMesh& mesh, const SurfaceResult& finest, const LeftView& view,
                     const config::Config& config, int threads, const RunLog& log);

}  // namespace hexrelief::job
