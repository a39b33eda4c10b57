// A disparity map at full, half, quarter ... size, for a smoothing from coarse to fine.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "mesher/common/thread_pool.h"
#include "pipeline/data/disparity_map.h"

namespace hexrelief::dequantize {

// What a pixel's flags say.
inline constexpr std::uint8_t kIsSmoothed = 1, kJoinsRight = 2, kJoinsBelow = 4, kBendsX = 8, kBendsY = 16,
                              kTwists = 32;

// One size. Row-major with one pixel of border, whose flags are 0 and whose values are finite.
// A pixel takes part (kIsSmoothed) or keeps its value; it joins its neighbour where both take part and lie on
// one surface; it bends where it joins both neighbours of its row or column, and twists where the square of
// it and its neighbours to the right and below is joined.
struct PyramidLevel {
    PyramidLevel(int columns, int rows);

    int width, height, stride;
    std::vector<float> given;  // px; 0 where a pixel does not take part
    std::vector<float> smooth{};
    std::vector<std::uint8_t> flags;

    std::size_t at(int x, int y) const { return static_cast<std::size_t>(y + 1) * stride + x + 1; }
};

// Pixels above half_quantum_px take part; neighbours that differ by at most join_px are joined. A coarse
// pixel takes part where its four are joined, as their mean. At most `levels` sizes, fine to coarse; smooth =
// given in all.
std::vector<PyramidLevel> build_pyramid(const DisparityMap& map, float half_quantum_px, float join_px,
                                        int levels, ThreadPool& pool);

// Lays the coarse level's surface over the fine one where it has one: along the planes between joined coarse
// pixels, within half_px of what was given.
void prolong(const PyramidLevel& coarse, PyramidLevel& fine, float half_px, ThreadPool& pool);

}  // namespace hexrelief::dequantize
