// Limits on the size of pictures and maps.
#pragma once

#include <string>
#include <vector>

namespace hexrelief::readers {

inline constexpr long long kMaxPixels = 1LL << 29;  // 536 Mpx: 16384 x 16384 twice over

struct ReaderLimits {
    long long max_pixels = kMaxPixels;  // 1 .. kMaxPixels
    // The key, or the option of the caller, that errors name.
    const char* max_pixels_option = "limits.max_pixels";
};

// carla: depths of up to 1000 m in 24 bits, red the lowest; sintel: disparities in px, 4 * red + green / 64 +
// blue / 16384; tartanair: depths in m, floats of 32 bits in alpha, red, green and blue.
enum class Packing { none, carla, sintel, tartanair };

// Returns the names in the order of Packing; the first is "none".
const std::vector<std::string>& packing_names();

}  // namespace hexrelief::readers
