// A part of a picture at less than its size.
#pragma once

#include "mesher/tiles/lattice_tiles.h"
#include "pipeline/windows/picture_windows.h"

namespace hexrelief::tiles {

// Means over squares of by x by px; x and y of the part are multiples of `by`, and it may end before a whole
// square. Memory: the result, and a band of the part.
Image shrunk_picture(const windows::PictureWindows& picture, const mesh_tiles::MapRect& part, int by);

}  // namespace hexrelief::tiles
