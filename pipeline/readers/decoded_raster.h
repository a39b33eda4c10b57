// Decoded samples, which may be a picture or a disparity map, and the description of a raster file whose
// samples are not decoded.
#pragma once

#include <bit>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "pipeline/data/image.h"
#include "pipeline/readers/limits.h"

namespace hexrelief::readers::codec {

// Returns the float whose bytes are those of `value` in reverse.
inline float in_other_byte_order(float value) {
    const auto v = std::bit_cast<std::uint32_t>(value);
    return std::bit_cast<float>(v >> 24 | (v >> 8 & 0xff00u) | (v << 8 & 0xff0000u) | v << 24);
}

inline constexpr double kNoData = std::numeric_limits<double>::quiet_NaN();

// A format's own statement about a depth map's samples.
struct StatedDepth {
    // depth: metres; inverse_depth: 1 / metres; relative_depth: in the units of a reconstruction.
    enum class Kind { nothing, depth, inverse_depth, relative_inverse, relative_depth };
    Kind kind = Kind::nothing;
    double step = 0;        // between adjacent samples, if these were converted to floats
    std::string told = {};  // the source of this information
};

struct PixelWindow {
    std::uint32_t x, y, width, height;
};

// Row-major, top row first, channels interleaved: 1 (grey) or 3 (red green blue). Samples are as stored:
// neither 1-2-4-bit samples nor those of a PGM with its own maxval are stretched, because the samples of a
// map mean the numbers themselves.
struct Raster {
    int width = 0;
    int height = 0;
    int channels = 1;
    // Value of full white in integer samples, 1..65535; 0 = they are a map's. Unused for floats.
    unsigned max_value = 255;
    // Sample value that the file itself declares to mean "unknown"; NaN = none.
    double nodata = kNoData;
    std::variant<std::vector<std::uint8_t>, std::vector<std::uint16_t>, std::vector<float>> samples = {};
    std::vector<std::uint8_t> alpha = {};  // 0..255 per pixel; empty = all are opaque
    StatedDepth stated = {};
    std::vector<std::uint8_t> profile = {};  // of its colours (ICC); empty = they are sRGB's
    // Width of integers that are held as floats, because they are negative or above 65535; 0 = there are
    // none.
    int integer_bits = 0;
    bool is_signed = false;  // these integers' type

    bool are_floats() const {
        return integer_bits == 0 && std::holds_alternative<std::vector<float>>(samples);
    }
};

// Returns "floats", "16-bit integers", "signed 16-bit integers".
std::string samples_name(const Raster& raster);

// Puts integers of any type into the raster: as unsigned ones of 16 bits if all of them fit.
void hold_integers(Raster& raster, std::vector<float> values, int bits, bool is_signed);

// Exchanges the first row with the last, and so on.
void flip_rows(std::vector<float>& values, int width);

// Returns the value of an IEEE number of 16 bits.
float float_of_half(std::uint16_t half);

// Moves the last of the raster's 2 or 4 channels, of 8 or 16 bits, to its alpha, which stays empty if
// no pixel is transparent.
void split_alpha(Raster& raster);

}  // namespace hexrelief::readers::codec

namespace hexrelief::readers {

// What a raster file's header tells.
struct FileDescription {
    std::string
        format;  // "png", "pgm", "ppm", "pfm", "jpeg", "tiff", "webp", "bmp", "heic", "npy", "npz", "exr"
    int width = 0;
    int height = 0;
    int channels = 0;  // as stored, alpha included; a palette counts as the channels of its colours
    int bits = 0;      // per sample: 1, 2, 4, 8, 16, 32 or 64
    bool is_float = false;
};

// Describes an image or disparity map, recognised by content, from its header (of NPZ and HEIC the whole
// file is read). Returns nullopt if the file has none of the formats above. Throws Error(input) if the file
// cannot be opened, or if it begins like one of the formats but its header is malformed or has more pixels
// than the limits allow.
std::optional<FileDescription> describe_raster(const std::filesystem::path& path, const std::string& key = {},
                                               const ReaderLimits& limits = {});

// Returns a line for each array of an NPZ file, or each part of an EXR file: names, types, sizes. Empty for
// other files. Throws Error(input) if the file is malformed.
std::vector<std::string> list_contents(const std::filesystem::path& path, const ReaderLimits& limits = {});

}  // namespace hexrelief::readers
