#include "pipeline/readers/decoded_raster.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "pipeline/data/error.h"
#include "pipeline/readers/codecs.h"

namespace hexrelief::readers::codec {
namespace {

// Reduces grey that some tool wrote as colour: three equal channels become one, in place.
template <typename Sample>
void keep_grey(std::vector<Sample>& samples, const std::filesystem::path& path) {
    const std::size_t pixels = samples.size() / 3;
    for (std::size_t i = 0; i < pixels; ++i) {
        const Sample *const pixel = samples.data() + 3 * i, first = pixel[0];
        const bool is_grey = (pixel[1] == first && pixel[2] == first) ||
                             (pixel[0] != pixel[0] && pixel[1] != pixel[1] && pixel[2] != pixel[2]);  // NaN
        if (!is_grey)
            refuse(
                path,
                "it is a colour picture, and a map has one channel; if red, green and blue together are one "
                "number, --packed carla, sintel or tartanair reads them (input.depth.packed, "
                "input.disparity.packed), "
                "and colours for the eye cannot be read");
        samples[i] = first;
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

// A number is the sum of the channels' products with these weights.
struct Weights {
    const char* told;
    double red, green, blue;
    double unknown = kNoData;  // of the numbers
};

constexpr double kCarla_m = 1000.0 / 16777215;  // 24 bits

constexpr Weights kWeights[] = {{},
                                {"CARLA's 24 bits", kCarla_m, 256 * kCarla_m, 65536 * kCarla_m, 1000},
                                {"Sintel's packed disparities", 4, 1.0 / 64, 1.0 / 16384, 0},
                                {"TartanAir's packed floats", 0, 0, 0}};

// Replaces a picture's colours by the numbers that they stand for. The path is for the message. Throws
// Error(input) for a raster without three channels of 8 bits.
void unpack(Raster& raster, Packing packing, const std::filesystem::path& path) {
    if (packing == Packing::none) return;
    const auto* const bytes = std::get_if<std::vector<std::uint8_t>>(&raster.samples);
    if (bytes == nullptr || raster.channels != 3)
        refuse(path, "it has no red, green and blue of 8 bits to unpack; leave --packed out");
    const bool are_floats = packing == Packing::tartanair;
    if (are_floats == raster.alpha.empty())
        refuse(path,
               are_floats
                   ? "its fourth channel holds nothing, as in no file of TartanAir's; see --packed"
                   : "its fourth channel holds a part of the numbers; --packed tartanair reads those of "
                     "TartanAir");
    const Weights& weights = kWeights[static_cast<std::size_t>(packing)];
    std::vector<float> numbers(bytes->size() / 3);
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        const std::uint32_t red = (*bytes)[3 * i], green = (*bytes)[3 * i + 1], blue = (*bytes)[3 * i + 2];
        numbers[i] =
            are_floats
                ? std::bit_cast<float>(std::uint32_t{raster.alpha[i]} << 24 | red << 16 | green << 8 | blue)
                : static_cast<float>(weights.red * red + weights.green * green + weights.blue * blue);
    }
    raster.samples = std::move(numbers);
    raster.channels = 1;
    raster.alpha.clear();
    raster.nodata = weights.unknown;
    raster.stated.told = weights.told;
}

}  // namespace

std::string samples_name(const Raster& raster) {
    if (raster.are_floats()) return "floats";
    const bool are_bytes = std::holds_alternative<std::vector<std::uint8_t>>(raster.samples);
    return (raster.is_signed ? "signed " : "") +
           std::to_string(raster.integer_bits > 0 ? raster.integer_bits
                          : are_bytes             ? 8
                                                  : 16) +
           "-bit integers";
}

void hold_integers(Raster& raster, std::vector<float> values, int bits, bool is_signed) {
    if (std::ranges::all_of(values, [](float value) { return value >= 0 && value <= 65535; })) {
        raster.max_value = 0;
        raster.samples = std::vector<std::uint16_t>(values.begin(), values.end());
        return;
    }
    raster.integer_bits = bits;
    raster.is_signed = is_signed;
    raster.samples = std::move(values);
}

void flip_rows(std::vector<float>& values, int width) {
    for (auto top = values.begin(), end = values.end(); end - top >= 2 * width; top += width, end -= width)
        std::swap_ranges(top, top + width, end - width);
}

float float_of_half(std::uint16_t half) {
    const std::uint32_t sign = (half & 0x8000u) << 16, exponent = half >> 10 & 31, fraction = half & 1023u;
    if (exponent == 0) {
        const float tiny = static_cast<float>(fraction) * 0x1p-24f;
        return sign ? -tiny : tiny;
    }
    const std::uint32_t wide = exponent == 31 ? 255 : exponent + 112;
    return std::bit_cast<float>(sign | wide << 23 | fraction << 13);
}

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
    const Gives gives = words.wanted == Wanted::confidence ? kConfidence : kMap;
    const std::string wanted = std::string(words.map) + " as one of " + names_of(gives);
    const Codec& codec = require_codec(path, wanted);
    if ((codec.gives & gives) == 0)
        refuse(path,
               std::string(codec.name) + " does not keep " + words.samples + " exactly; give " + wanted);
    SourceFile source = load_raster_file(path, limits);
    source.key = key;
    source.several = words.several;
    source.wanted = words.wanted;
    source.is_map = true;
    Raster raster = codec.decode(source);
    unpack(raster, words.packing, path);
    if (raster.channels == 3) std::visit([&](auto& values) { keep_grey(values, path); }, raster.samples);
    raster.channels = 1;
    if (raster.are_floats() && in_other_order(std::get<std::vector<float>>(raster.samples)))
        refuse_byte_order(path);
    return raster;
}

}  // namespace hexrelief::readers::codec

const std::vector<std::string>& hexrelief::readers::packing_names() {
    static const std::vector<std::string> names = {"none", "carla", "sintel", "tartanair"};
    return names;
}

namespace hexrelief::readers {
namespace {

// True for archives and photographs, whose contents can only be found by reading the whole file.
bool needs_all_bytes(const codec::Codec& codec) {
    return codec.format == codec::Format::npz || codec.format == codec::Format::heic;
}

FileDescription describe_head(const codec::Codec& codec, const std::filesystem::path& path,
                              const std::string& key, const ReaderLimits& limits) {
    // Metadata may come before the size: if the first bytes do not contain the size, more are tried.
    constexpr std::size_t first = 1 << 16, most = 1 << 26;
    for (std::size_t count = first;; count *= 32) {
        codec::SourceFile source = codec::open_file(path, count);
        source.key = key;
        source.limits = limits;
        try {
            return codec.describe(source);
        } catch (const Error&) {
            if (!source.file || count >= most) throw;
        }
    }
}

}  // namespace

std::optional<FileDescription> describe_raster(const std::filesystem::path& path, const std::string& key,
                                               const ReaderLimits& limits) {
    const codec::Codec* codec = codec::find_codec(path);
    if (!codec) return std::nullopt;
    if (!needs_all_bytes(*codec)) return describe_head(*codec, path, key, limits);
    codec::SourceFile source = codec::load_raster_file(path, limits);
    source.key = key;
    return codec->describe(source);
}

std::vector<std::string> list_contents(const std::filesystem::path& path, const ReaderLimits& limits) {
    const codec::Codec* codec = codec::find_codec(path);
    if (!codec || !codec->list) return {};
    return codec->list(codec::load_raster_file(path, limits));
}

}  // namespace hexrelief::readers
