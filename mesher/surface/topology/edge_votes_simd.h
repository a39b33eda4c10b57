// Loops over which triangles' pixels are, eight pixels side by side.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "mesher/surface/topology/rasterize_step.h"

namespace hexrelief {

inline constexpr std::size_t kPlaceLanes = 8;

// Of all pixels, with kPlaceLanes more behind them.
struct PlaceView {
    int width, height;
    const std::uint32_t* places;  // step::place_of()
    const std::uint8_t* flags;
};

// What pairs of neighbouring pixels across each of a triangle's edges say: so many that it is open, or not.
struct EdgeVotes {
    std::uint32_t open[3], closed[3];
};

// runs: of the triangle's pixels; those at own_side count. towards: the triangles across the edges, as
// step::belongs() tells them, or what no pixel has.
EdgeVotes count_votes(const PlaceView& pixels, std::span<const PixelRun> runs, std::uint32_t own_side,
                      const std::uint32_t towards[3]);

// Whether one of the runs' pixels is not the triangle's that own_side is a place of.
bool holds_others(const PlaceView& pixels, std::span<const PixelRun> runs, std::uint32_t own_side);

}  // namespace hexrelief
