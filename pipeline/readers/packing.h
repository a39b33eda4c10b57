// The ways in which a picture's colours hold one number.
#pragma once

#include <string>
#include <vector>

namespace hexrelief::readers {

// carla: depths of up to 1000 m in 24 bits, red the lowest; sintel: disparities in px, 4 * red + green / 64 +
// blue / 16384; tartanair: depths in m, floats of 32 bits in alpha, red, green and blue.
enum class Packing { none, carla, sintel, tartanair };

// Returns the names in the order of Packing; the first is "none".
const std::vector<std::string>& packing_names();

}  // namespace hexrelief::readers
