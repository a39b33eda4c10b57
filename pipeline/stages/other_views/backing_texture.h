// A backing behind what continues in front of it, and its texture.
#pragma once

#include "pipeline/base/thread_pool.h"
#include "pipeline/data/image.h"
#include "pipeline/stages/other_views/continued.h"
#include "pipeline/stages/other_views/other_view.h"

namespace hexrelief::stages {

// Moves a backing behind what continues in the view, `missing`.
void keep_behind_continued(OtherView& backing, const DisparityMap& missing);

// Returns the part of a backing that is to get a texture of its own, without colours: behind what the view
// shows, unless the same surface continues there. front: the disparities of the view, whose place is as large
// as the backing or a little larger. The same for any number of threads.
Continued backing_behind(const Continued& continued, const OtherView& backing, const Disparities& front,
                         const ViewPlace& place, ThreadPool& pool);

// Gives the backing the view's picture at half its size, as it is seen through gaps only, with what continues
// painted, and in its part `behind` the texture of the farther surfaces, or its own colours if there is none.
// The same for any number of threads.
void paint_backing(OtherView& backing, const Image& picture, const ViewPlace& place, Continued behind,
                   const Disparities& front, ThreadPool& pool);

}  // namespace hexrelief::stages
