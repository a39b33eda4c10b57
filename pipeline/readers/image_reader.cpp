#include "pipeline/readers/image_reader.h"

#include <lcms2.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <memory>

namespace hexrelief::readers {
namespace codec {
namespace {

// Returns sRGB's transfer function from encoded values to linear light (IEC 61966-2-1).
double linear_light(double encoded) {
    return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

// The samples from which on each byte but 0 is the nearest.
std::array<float, 255> thresholds_of(FloatColors kind) {
    std::array<float, 255> thresholds{};
    for (std::size_t i = 0; i < thresholds.size(); ++i) {
        const double middle = (static_cast<double>(i) + 0.5) / 255;
        thresholds[i] = static_cast<float>(kind == FloatColors::linear ? linear_light(middle) : middle);
    }
    return thresholds;
}

}  // namespace

Raster to_bytes(const Raster& colors, FloatColors kind, const std::filesystem::path& path) {
    const auto& samples = std::get<std::vector<float>>(colors.samples);
    const auto above = std::ranges::count_if(samples, [](float sample) { return sample > 1; });
    if (2 * static_cast<std::size_t>(above) > samples.size())
        refuse(path, "most of its float colours are above 1, which is white; save it with 8 or 16 bits");
    const std::array<float, 255> thresholds = thresholds_of(kind);
    std::vector<std::uint8_t> bytes(samples.size());
    std::ranges::transform(samples, bytes.begin(), [&](float sample) {
        if (std::isnan(sample)) return std::uint8_t{0};
        return static_cast<std::uint8_t>(std::ranges::upper_bound(thresholds, sample) - thresholds.begin());
    });
    return {colors.width, colors.height, colors.channels, 255, kNoData, std::move(bytes), colors.alpha};
}

}  // namespace codec

namespace {

struct Close {
    void operator()(void* profile) const { cmsCloseProfile(profile); }
};
struct Delete {
    void operator()(void* transform) const { cmsDeleteTransform(transform); }
};
using Profile = std::unique_ptr<void, Close>;
using Transform = std::unique_ptr<void, Delete>;

// Returns sRGB, or greys of sRGB's curve (IEC 61966-2-1).
Profile srgb(bool is_grey) {
    if (!is_grey) return Profile(cmsCreate_sRGBProfile());
    const double curve[] = {2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045};
    cmsToneCurve* const tones = cmsBuildParametricToneCurve(nullptr, 4, curve);
    Profile profile(cmsCreateGrayProfile(cmsD50_xyY(), tones));
    cmsFreeToneCurve(tones);
    return profile;
}

// Returns colours from all over the cube, or all greys.
std::vector<std::uint8_t> probes(bool is_grey) {
    constexpr int kStep = 15;
    std::vector<std::uint8_t> samples;
    const auto add = [&samples](int sample) { samples.push_back(static_cast<std::uint8_t>(sample)); };
    for (int i = 0; is_grey && i < 256; ++i) add(i);
    for (int r = 0; !is_grey && r < 256; r += kStep)
        for (int g = 0; g < 256; g += kStep)
            for (int b = 0; b < 256; b += kStep) {
                add(r);
                add(g);
                add(b);
            }
    return samples;
}

// False if samples change by no more than profiles of sRGB from different programs differ.
bool changes_colors(void* transform, int channels) {
    constexpr int kRounding = 2;
    const std::vector<std::uint8_t> samples = probes(channels == 1);
    std::vector<std::uint8_t> converted(samples.size());
    cmsDoTransform(transform, samples.data(), converted.data(),
                   static_cast<cmsUInt32Number>(samples.size() / channels));
    return !std::ranges::equal(samples, converted, [](int a, int b) { return std::abs(a - b) <= kRounding; });
}

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

void to_srgb(Image& image, const std::vector<std::uint8_t>& profile) {
    if (profile.empty() || profile.size() > kLongestProfile) return;
    const bool is_grey = image.channels == 1;
    const Profile from(cmsOpenProfileFromMem(profile.data(), static_cast<cmsUInt32Number>(profile.size())));
    if (!from || cmsGetColorSpace(from.get()) != (is_grey ? cmsSigGrayData : cmsSigRgbData)) return;
    const Profile to = srgb(is_grey);
    const cmsUInt32Number format = is_grey ? TYPE_GRAY_8 : TYPE_RGB_8;
    const Transform transform(
        cmsCreateTransform(from.get(), format, to.get(), format, INTENT_RELATIVE_COLORIMETRIC, 0));
    if (!transform || !changes_colors(transform.get(), image.channels)) return;
    for (int y = 0; y < image.height; ++y)
        cmsDoTransform(transform.get(), image.at(0, y), image.at(0, y),
                       static_cast<cmsUInt32Number>(image.width));
}

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
