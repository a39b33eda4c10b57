// What the right photograph shows beyond the left one's frame.
#pragma once

#include "pipeline/stages/other_views/other_view.h"

namespace hexrelief::stages {

// Adds to `missing` of the right camera's view what its picture (`kept`) shows beside both ends of each row
// of the surface: the last disparity goes on, the smoother along the columns the farther it lies from there.
// What lies rather above or below the surface is left out: the row there ends far away. here: the surface as
// the right view shows it.
void continue_beyond_left(OtherView& right, const SeenSurface& here);

// Drops the triangles of the right camera's view with a corner that its picture does not show: thin parts
// along its border are cut into teeth that stick out of it.
void drop_not_shown(DisparityMesh& cut_mesh, const OtherView& right);

}  // namespace hexrelief::stages
