#include "pipeline/readers/image_reader.h"

#include <algorithm>

#include "pipeline/readers/codecs.h"
#include "pipeline/readers/color_profile.h"
#include "pipeline/readers/float_colors.h"

namespace hexrelief::readers {
namespace {

// Scales 0..max_value to 0..255, rounded; samples beyond the maxval that a PGM declares are white.
template <typename Sample>
std::vector<std::uint8_t> to_bytes(const std::vector<Sample>& samples, unsigned max_value) {
    std::vector<std::uint8_t> bytes(samples.size());
    std::transform(samples.begin(), samples.end(), bytes.begin(), [max_value](Sample sample) {
        const unsigned value = std::min<unsigned>(sample, max_value);
        return static_cast<std::uint8_t>((value * 255u + max_value / 2) / max_value);
    });
    return bytes;
}

}  // namespace

const codec::Codec& require_image_codec(const std::filesystem::path& path) {
    const std::string wanted = "an image as one of " + codec::names_of(codec::kPicture);
    const codec::Codec& codec = codec::require_codec(path, wanted);
    if ((codec.gives & codec::kPicture) == 0)
        codec::refuse(path, std::string("an ") + codec.name + " file is a map, not an image; give " + wanted);
    return codec;
}

Image read_image(const std::filesystem::path& path, const ReaderLimits& limits) {
    const codec::Codec& codec = require_image_codec(path);
    // The file is a temporary here, so that its bytes are freed before the samples are converted.
    codec::Raster raster = codec.decode(codec::load_raster_file(path, limits));
    if (raster.channels == 3 && std::holds_alternative<std::vector<float>>(raster.samples)) {
        const bool is_linear = codec.format == codec::Format::exr;
        raster = codec::to_bytes(raster, is_linear ? codec::FloatColors::linear : codec::FloatColors::encoded,
                                 path);
    }
    return image_of(std::move(raster), path);
}

Image image_of(codec::Raster raster, const std::filesystem::path& path) {
    if (raster.max_value == 0 && !raster.are_floats())
        codec::refuse(path,
                      "its integers are signed or of 32 bits; save it with 8 or 16 bits without a sign");
    Image image;
    image.width = raster.width;
    image.height = raster.height;
    image.channels = raster.channels;
    image.alpha = std::move(raster.alpha);
    if (auto* bytes = std::get_if<std::vector<std::uint8_t>>(&raster.samples)) {
        image.pixels = raster.max_value == 255 ? std::move(*bytes) : to_bytes(*bytes, raster.max_value);
    } else if (const auto* wide = std::get_if<std::vector<std::uint16_t>>(&raster.samples)) {
        image.pixels = to_bytes(*wide, raster.max_value);
    } else {
        codec::refuse(path,
                      "it holds float samples, so it is a map, not an image; save it with 8 or 16 bits");
    }
    to_srgb(image, raster.profile);
    return image;
}

}  // namespace hexrelief::readers
