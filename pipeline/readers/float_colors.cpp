#include "pipeline/readers/float_colors.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/readers/source.h"

namespace hexrelief::readers::codec {
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

}  // namespace hexrelief::readers::codec
