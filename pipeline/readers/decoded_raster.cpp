#include "pipeline/readers/decoded_raster.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "pipeline/readers/codecs.h"

namespace hexrelief::readers::codec {
namespace {

// Reduces grey that some tool wrote as colour: three equal channels become one, in place.
template <typename Sample>
void keep_grey(std::vector<Sample>& samples, const std::filesystem::path& path) {
    const std::size_t pixels = samples.size() / 3;
    for (std::size_t i = 0; i < pixels; ++i) {
        if (samples[3 * i] != samples[3 * i + 1] || samples[3 * i] != samples[3 * i + 2])
            refuse(path, "it is a colour picture, a map has one channel; save it as grey");
        samples[i] = samples[3 * i];
    }
    samples.resize(pixels);
}

// True for plausible disparities and depths, between a millionth and a million; floats read in the wrong byte
// order hardly ever are.
bool plausible(float value) {
    return std::abs(value) >= 1e-6f && std::abs(value) <= 1e6f;
}

// Removes the last of `channels` samples of each pixel and returns them as bytes.
template <typename Sample>
std::vector<std::uint8_t> take_last(std::vector<Sample>& samples, std::size_t channels) {
    std::vector<std::uint8_t> last(samples.size() / channels);
    auto to = samples.begin();
    for (std::size_t i = 0; i < last.size(); ++i) {
        const auto pixel = samples.begin() + static_cast<std::ptrdiff_t>(i * channels);
        last[i] = static_cast<std::uint8_t>(pixel[channels - 1] >> (8 * sizeof(Sample) - 8));
        to = std::copy(pixel, pixel + static_cast<std::ptrdiff_t>(channels - 1), to);
    }
    samples.erase(to, samples.end());
    return last;
}

}  // namespace

void split_alpha(Raster& raster) {
    std::visit(
        [&](auto& samples) {
            if constexpr (!std::is_same_v<decltype(samples), std::vector<float>&>)
                raster.alpha = take_last(samples, raster.channels);
        },
        raster.samples);
    --raster.channels;
    if (std::ranges::none_of(raster.alpha, [](std::uint8_t alpha) { return alpha < kOpaque; }))
        raster.alpha.clear();
}

bool in_other_order(const std::vector<float>& samples) {
    std::size_t judged = 0, as_read = 0, swapped = 0;
    for (float sample : samples) {
        // 0 and infinity mean unknown. Infinity in the other byte order is a tiny number, which
        // is ignored as well.
        if (sample == 0 || std::isinf(sample) || std::isinf(in_other_byte_order(sample))) continue;
        ++judged;
        as_read += plausible(sample);
        swapped += plausible(in_other_byte_order(sample));
    }
    return judged > 0 && 2 * as_read < judged && 2 * swapped >= judged;
}

void refuse_byte_order(const std::filesystem::path& path) {
    refuse(path,
           "its floats make sense only in the other byte order, so the sign of the scale in its header is "
           "wrong; negative means little endian, correct that line");
}

Raster read_map_raster(const std::filesystem::path& path, const MapWords& words, const std::string& key,
                       const ReaderLimits& limits) {
    const Codec& codec = require_codec(
        path, (std::string(words.map) + " as PNG, PGM (P5), PFM, TIFF, NPY, NPZ, EXR or HEIC").c_str());
    if (codec.format == Format::jpeg || codec.format == Format::webp)
        refuse(path, std::string(codec.name) + " does not keep " + words.samples +
                         " exactly; give the map as PNG, PGM, PFM, TIFF, NPY or EXR");
    SourceFile source = load_raster_file(path, limits);
    source.key = key;
    source.several = words.several;
    source.is_map = true;
    Raster raster = codec.decode(source);
    if (raster.channels == 3 && std::holds_alternative<std::vector<float>>(raster.samples))
        refuse(path, std::string("it has three channels of floats, ") + words.map +
                         " has one; save it as grey (PFM: Pf)");
    if (raster.channels == 3) std::visit([&](auto& values) { keep_grey(values, path); }, raster.samples);
    raster.channels = 1;
    if (const auto* floats = std::get_if<std::vector<float>>(&raster.samples))
        if (in_other_order(*floats)) refuse_byte_order(path);
    return raster;
}

}  // namespace hexrelief::readers::codec
