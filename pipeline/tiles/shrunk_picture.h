// Reads a part of a picture at a reduced size.
#pragma once

#include "mesher/tiles/lattice_tiles.h"
#include "pipeline/readers/windows/map_windows.h"

namespace hexrelief::tiles {

// Returns the means over squares of by x by px. x and y of the part are multiples of `by`; it may end within
// a square. Memory: the result, and a band of the part.
Image shrunk_picture(const readers::PictureWindows& picture, const mesh_tiles::MapRect& part, int by);

}  // namespace hexrelief::tiles
