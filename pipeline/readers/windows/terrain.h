// A synthetic disparity map of any size.
#pragma once

#include <cstdint>

#include "pipeline/readers/windows/map_writer.h"

namespace hexrelief::readers {

// Computes the disparities of `count` pixels of row y from x on: hills (value noise of nine octaves), cliffs
// along curved lines, buildings with flat roofs and straight walls; lakes and single pixels are unknown. They
// depend only on (x, y, seed), for x and y of 0 to kLargestMapSide_px, with the same bits on every machine
// and in every call. Known disparities are 20 to 256 px.
void terrain_row(int x, int y, int count, std::uint32_t seed, float* out);

// Writes all rows of a map of this size, computed by `threads` threads, which change no byte. Does
// not finish the file.
void write_terrain(MapWriter& writer, int width, int height, std::uint32_t seed, int threads);

}  // namespace hexrelief::readers
