// Semi-global matching of a pair (Hirschmueller 2008), on census and colour.
#pragma once

#include <cstddef>

#include "mesher/common/thread_pool.h"
#include "pipeline/matching/common/color_planes.h"
#include "pipeline/matching/sgm/path_step.h"
#include "pipeline/matching/sgm/winners.h"

namespace hexrelief {

// A picture with a larger volume than this, in bytes, is matched in bands of rows, each with kBandMargin rows
// more on both sides, from which the vertical paths start.
inline constexpr std::size_t kLargestVolume_bytes = std::size_t{1980} << 20;
inline constexpr int kBandMargin = 64;

// Rows that a band may have, its margins included; the same for CPU and CUDA, so that their bytes are.
int band_rows(int width, int height);

// The volume that the CPU keeps at once, in bytes; smaller than a cache shared by the cores.
inline constexpr std::size_t kBlock_bytes = std::size_t{32} << 20;

// The windows of all pixels of a picture, from the left view's winners at half size; the whole range where
// it has up to kSearched disparities, without reading half.
SearchWindows find_windows(int width, int height, const DisparityRange& range, DisparityView half,
                           ThreadPool& pool);

// Winners of both views. range.count: 1..1920. block_bytes changes no bit of them.
ViewDisparities match_views(const ColorPlanes& left, const ColorPlanes& right, const DisparityRange& range,
                            WindowView windows, const step::PathPenalties& penalties, ThreadPool& pool,
                            std::size_t block_bytes = kBlock_bytes);

}  // namespace hexrelief
