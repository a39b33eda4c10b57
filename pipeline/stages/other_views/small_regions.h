// Regions of a map that are too small for a surface.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipeline/data/disparity_map.h"
#include "pipeline/stages/surface_raster.h"

namespace hexrelief::stages {

// Calls take(i) for a pixel and its neighbours i, in the order of rows.
template <class Take>
void for_neighbours(const DisparityMap& map, std::uint32_t pixel, const Take& take) {
    const auto width = static_cast<std::uint32_t>(map.width);
    const int x = static_cast<int>(pixel % width), y = static_cast<int>(pixel / width);
    const int left = std::max(0, x - 1), right = std::min(map.width - 1, x + 1);
    for (int v = std::max(0, y - 1); v <= std::min(map.height - 1, y + 1); ++v)
        for (int u = left; u <= right; ++u) take(static_cast<std::uint32_t>(v) * width + u);
}

// Returns the pixels of those regions that have fewer than `least` pixels. Neighbours that differ by more
// than `step_px` are in two regions.
std::vector<std::uint32_t> specks_of(const DisparityMap& map, std::size_t least, double step_px);

inline constexpr std::size_t kLeastSurface = 60;  // pixels of a surface of its own

// Gives regions of fewer than `least` pixels to the surfaces around them. In a region neighbours in different
// rows differ by up to 3 px, for a floor rises. Those alone stay, unless nobody would miss them.
void merge_specks(DisparityMap& map, std::size_t least = kLeastSurface);

// Returns per pixel 1 where the map is known.
std::vector<std::uint8_t> known_pixels(const DisparityMap& map);

// Lets pixels fall towards what lies farther beside them by at most most_px, in ramps of 0.9 px a pixel, so
// that such a step parts nothing. Those of is_shown, per pixel 0 or 1, stay.
void ramp_steps(DisparityMap& map, const std::vector<std::uint8_t>& is_shown, double most_px);

// Returns those pixels of small regions that themselves touch a surface: a neighbour is covered by one within
// 1 px of disparity. surface: per pixel a disparity or kNotCovered.
std::vector<std::uint32_t> cracks_of(const DisparityMap& map, const Disparities& surface);

}  // namespace hexrelief::stages
