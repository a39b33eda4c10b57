// Judges how well a matched pair supports its mesh.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/data/disparity_map.h"

namespace hexrelief::checks {

// Returns the share of the left picture's textured pixels on which both views agree, 0..1: 0 without texture.
// Texture: blocks of 8 x 8 px that show more than noise. Left out are pixels that `is_kept` (of the map's
// size, or empty) sets to 0, and those whose disparity places them left of the right picture. `map` was
// matched.
double measure_support(const Image& left, const DisparityMap& map, const std::vector<std::uint8_t>& is_kept);

// A pair's support in words: "good", "partly" or "hardly".
const char* support_word(double support);
bool is_hardly_supported(double support);

}  // namespace hexrelief::checks
