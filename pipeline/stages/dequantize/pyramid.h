// A disparity map at full, half, quarter ... size, for smoothing from coarse to fine.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipeline/base/thread_pool.h"
#include "pipeline/data/disparity_map.h"

namespace hexrelief::stages {

// The flags of a pixel.
inline constexpr std::uint8_t kIsSmoothed = 1, kJoinsRight = 2, kJoinsBelow = 4, kBendsX = 8, kBendsY = 16,
                              kTwists = 32;

// A level of the pyramid: row-major with one pixel of border, whose flags are 0 and whose values are finite.
//
// A pixel either takes part (kIsSmoothed) or keeps its value. It joins its right or lower neighbour if both
// take part and lie on one surface. It bends if it is joined to both neighbours in its row or column, and
// twists if the square of it and its neighbours to the right and below is joined.
struct PyramidLevel {
    PyramidLevel(int columns, int rows);

    int width, height, stride;
    std::vector<float> given;  // px; 0 for pixels that do not take part
    std::vector<float> smooth{};
    std::vector<std::uint8_t> flags;
    std::vector<float> pull{};  // of each pixel, if they differ; else empty

    std::size_t at(int x, int y) const { return static_cast<std::size_t>(y + 1) * stride + x + 1; }
};

// Builds at most `levels` levels, fine to coarse, with smooth = given. Pixels above half_quantum_px take
// part; neighbours that differ by at most join_px are joined, and so are those down a column whose step the
// surface stage takes for a slope (step::is_slope()). A coarse pixel takes part, with the mean as its
// value, if its four fine pixels are joined.
std::vector<PyramidLevel> build_pyramid(const DisparityMap& map, float half_quantum_px, float join_px,
                                        int levels, ThreadPool& pool);

// Adds coarser levels to the finest one, whose given values, pulls and joins are set, until there are
// `levels`; smooth = given on all. A coarse pixel's value is the mean of its four fine ones weighted by their
// pulls.
void complete_pyramid(std::vector<PyramidLevel>& pyramid, int levels, ThreadPool& pool);

// Interpolates the coarse level's surface at the fine level's pixels, wherever there is a coarse one: along
// the planes between joined coarse pixels, within half_px of the given values.
void prolong(const PyramidLevel& coarse, PyramidLevel& fine, float half_px, ThreadPool& pool);

// Moves level.smooth towards the minimum of the sum over pixels of
//     xx^2 + yy^2 + 2 xy^2 + pull (smooth - given)^2,   |smooth - given| <= half_px,
// in which xx and yy are the second differences along x and y at pixels that bend, and xy is the mixed
// difference of the square to the right and below at pixels that twist. There are two rounds of four steps,
// whose lengths damp waves of all lengths by Chebyshev's polynomial. Each step reads one map and writes
// another, so the order of pixels does not matter.
void relax(PyramidLevel& level, float pull, float half_px, ThreadPool& pool);

// Does the same with the level's own pulls, without bounds, in as many rounds.
void relax_weighted(PyramidLevel& level, int rounds, ThreadPool& pool);

}  // namespace hexrelief::stages
