// Row bands for pictures whose cost volume exceeds kLargestVolume_bytes.
#pragma once

#include <cstddef>
#include <vector>

#include "pipeline/base/host_device.h"

namespace hexrelief::matching {

// A picture whose volume, counted with kWholeRange disparities per pixel, exceeds this number of
// bytes is matched in bands of rows. Each band has kBandMargin more rows above and below, in which
// the vertical paths start.
inline constexpr std::size_t kLargestVolume_bytes = std::size_t{1980} << 20;
inline constexpr int kBandMargin = 64;

struct Rows {
    int first, end;
    HEXRELIEF_HD int count() const { return end - first; }
};
// A band: the rows that are matched, margins included, and those whose result is kept.
struct Band {
    Rows rows, kept;
};

// Returns the largest number of rows of a band, its margins included.
int band_rows(int width, int height);

// Returns the bands, top to bottom. CPU and CUDA use the same bands, so their results are identical.
std::vector<Band> bands_of(int width, int height);

}  // namespace hexrelief::matching
