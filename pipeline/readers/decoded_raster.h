// Decoded samples before anyone has decided whether they are a picture or a disparity map.
#pragma once

#include <bit>
#include <cstdint>
#include <limits>
#include <string>
#include <variant>
#include <vector>

#include "pipeline/data/image.h"

namespace hexrelief::readers::codec {

// The float whose bytes are those of `value` in reverse.
inline float in_other_byte_order(float value) {
    const auto v = std::bit_cast<std::uint32_t>(value);
    return std::bit_cast<float>(v >> 24 | (v >> 8 & 0xff00u) | (v << 8 & 0xff0000u) | v << 24);
}

inline constexpr double kNoData = std::numeric_limits<double>::quiet_NaN();

// What a format itself says of a depth map's samples.
struct StatedDepth {
    enum class Kind { nothing, depth, inverse_depth, relative_inverse };  // the middle two are of metres
    Kind kind = Kind::nothing;
    double step = 0;        // between neighbouring samples where they were made floats
    std::string told = {};  // where from
};

struct PixelWindow {
    std::uint32_t x, y, width, height;
};

// Row-major, top row first, channels interleaved: 1 (grey) or 3 (red green blue). Samples are as stored:
// neither the 1-2-4-bit ones nor those of a PGM with a maxval of its own are stretched, because a map means
// the number itself.
struct Raster {
    int width = 0;
    int height = 0;
    int channels = 1;
    unsigned max_value = 255;  // what full white is in integer samples, 1..65535; unused for float
    // Sample that the file itself says means "not known"; NaN = it says none.
    double nodata = kNoData;
    std::variant<std::vector<std::uint8_t>, std::vector<std::uint16_t>, std::vector<float>> samples;
    std::vector<std::uint8_t> alpha = {};  // 0..255 of each pixel; empty = all are opaque
    StatedDepth stated = {};
};

// The last of the raster's 2 or 4 channels, of 8 or 16 bits, becomes its alpha, where a pixel is transparent.
void split_alpha(Raster& raster);

}  // namespace hexrelief::readers::codec
