// The paths of semi-global matching: from above, below, the left and the right.
#pragma once

#include "cuda/matching/sgm/pictures.h"
#include "cuda/matching/sgm/volume.h"
#include "cuda/matching/sgm/winners.h"

namespace hexrelief::cuda {

inline constexpr int kMostDisparities = 2048;

// Entries a pixel of a volume with this many disparities.
int volume_pitch(int count);

enum class PathDirection { down, up, right, left };

struct PathInput {
    const PairArrays& pair;
    DeviceVolume volume;
    WinnerKeys keys;
    int p1, min_px;
};

// Walks all paths of one direction. Vertical paths begin and end with the band's rows. `down` comes first and
// sets the sums of the band's kept rows, the others add to them; `left` comes last, for all rows that the
// volume keeps, and sets the keys, the right view's only where they match a pixel.
void walk_paths(cudaStream_t stream, PathDirection direction, const PathInput& input, const Band& band);

}  // namespace hexrelief::cuda
