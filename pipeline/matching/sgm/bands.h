// Bands of rows, in which a picture is matched whose volume would be too large.
#pragma once

#include <cstddef>
#include <vector>

#include "mesher/common/host_device.h"

namespace hexrelief::matching {

// A picture with a larger volume than this, in bytes of ranges that are searched wholly, is matched in bands
// of rows, each with kBandMargin rows more on both sides, from which the vertical paths start.
inline constexpr std::size_t kLargestVolume_bytes = std::size_t{1980} << 20;
inline constexpr int kBandMargin = 64;

struct Rows {
    int first, end;
    HEXRELIEF_HD int count() const { return end - first; }
};
// `rows` are matched: those kept, and the margins.
struct Band {
    Rows rows, kept;
};

// Rows that a band may have, its margins included.
int band_rows(int width, int height);

// From above; the same for CPU and CUDA, so that their bytes are.
std::vector<Band> bands_of(int width, int height);

}  // namespace hexrelief::matching
