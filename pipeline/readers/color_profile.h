// Colours by the profile in their file (ICC.1), such as a phone's Display P3, as sRGB.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/data/image.h"

namespace hexrelief::readers {

// Longer profiles are ignored; those of cameras and screens have some hundred bytes.
inline constexpr std::size_t kLongestProfile = 4 << 20;

// Converts the samples from the profile's colours to sRGB, relative to its white, and clips what sRGB does
// not reach. The image stays as it is if the profile is that of sRGB, of other colours than the image's (grey
// or RGB), malformed, or empty.
void to_srgb(Image& image, const std::vector<std::uint8_t>& profile);

}  // namespace hexrelief::readers
