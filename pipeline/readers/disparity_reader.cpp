#include "pipeline/readers/disparity_reader.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "pipeline/data/error.h"
#include "pipeline/readers/codecs.h"

namespace hexrelief {
namespace {

constexpr double kKittiScale = 256;

void check_config(const DisparityFileConfig& config) {
    if (!std::isfinite(config.scale) || config.scale < 0) {
        throw Error(ErrorKind::usage, "input.disparity.scale is " + std::to_string(config.scale) +
                                          "; it must be a positive number, or 0 where the format says it");
    }
    if (!std::isfinite(config.offset_px)) {
        throw Error(ErrorKind::usage, "input.disparity.offset must be a finite number of pixels");
    }
}

// Grey that some tool wrote as colour: three equal channels become one, in place.
template <typename Sample>
void keep_grey(std::vector<Sample>& samples, const std::filesystem::path& path) {
    const std::size_t pixels = samples.size() / 3;
    for (std::size_t i = 0; i < pixels; ++i) {
        if (samples[3 * i] != samples[3 * i + 1] || samples[3 * i] != samples[3 * i + 2]) {
            codec::refuse(
                path,
                "it is a colour picture, a disparity map has one channel; save the disparities as grey");
        }
        samples[i] = samples[3 * i];
    }
    samples.resize(pixels);
}

// Disparities lie between a millionth and a million pixels; floats read in the wrong byte order hardly ever
// do.
bool plausible(float value) {
    return std::abs(value) >= 1e-6f && std::abs(value) <= 1e6f;
}

void check_byte_order(const std::vector<float>& samples, const std::filesystem::path& path) {
    std::size_t judged = 0, as_read = 0, swapped = 0;
    for (float sample : samples) {
        // 0 and infinity mean unknown. Infinity in the other byte order is a tiny number, which is left out
        // as well.
        if (sample == 0 || std::isinf(sample) || std::isinf(codec::in_other_byte_order(sample))) continue;
        ++judged;
        as_read += plausible(sample);
        swapped += plausible(codec::in_other_byte_order(sample));
    }
    if (judged == 0 || 2 * as_read >= judged || 2 * swapped < judged) return;
    codec::refuse(
        path,
        "its floats make sense only in the other byte order, so the sign of the scale in its header is "
        "wrong; negative means little endian, correct that line");
}

float usable(double disparity) {
    const auto value = static_cast<float>(disparity);
    return std::isfinite(value) ? value : kUnknownDisparity;
}

template <typename Sample>
std::vector<float> integers_to_px(const std::vector<Sample>& samples, double scale,
                                  const DisparityFileConfig& config) {
    const double unknown = std::isnan(config.unknown) ? 0 : config.unknown;
    std::vector<float> values(samples.size());
    std::transform(samples.begin(), samples.end(), values.begin(), [&](Sample raw) {
        return raw == unknown ? kUnknownDisparity : usable(raw / scale + config.offset_px);
    });
    return values;
}

std::vector<float> floats_to_px(std::vector<float> samples, double scale, const DisparityFileConfig& config) {
    const auto unknown = static_cast<float>(config.unknown);
    for (float& sample : samples) {
        const bool known = std::isfinite(sample) && sample > 0 && sample != unknown;
        sample = known ? usable(sample / scale + config.offset_px) : kUnknownDisparity;
    }
    return samples;
}

[[noreturn]] void refuse_missing_scale(const std::filesystem::path& path, const std::string& option) {
    codec::refuse(path, "an 8-bit disparity map does not say how many grey levels are one pixel; give " +
                            option +
                            ". Middlebury's scales: 2001 sets 8 (tsukuba 16); 2003 quarter size 4, half 2, "
                            "full 1; 2005/2006 third size 3, half 2, full 1");
}

}  // namespace

DisparityMap read_disparity_map(const std::filesystem::path& path, const DisparityFileConfig& config) {
    check_config(config);
    const codec::Codec& codec = codec::require_codec(path, "a disparity map as PNG, PGM (P5), PFM or TIFF");
    if (codec.format == codec::Format::jpeg || codec.format == codec::Format::webp) {
        codec::refuse(path, std::string(codec.name) +
                                " does not keep disparities exactly; give the map as PNG, PGM, PFM or TIFF");
    }
    codec::Raster raster = codec.decode(codec::load_raster_file(path));
    if (raster.channels == 3 && std::holds_alternative<std::vector<float>>(raster.samples))
        codec::refuse(path,
                      "it has three channels of floats, a disparity map has one; save it as grey (PFM: Pf)");
    if (raster.channels == 3) std::visit([&](auto& samples) { keep_grey(samples, path); }, raster.samples);

    DisparityMap map;
    map.width = raster.width;
    map.height = raster.height;
    const bool given = config.scale > 0;
    if (const auto* bytes = std::get_if<std::vector<std::uint8_t>>(&raster.samples)) {
        if (!given) refuse_missing_scale(path, config.scale_option);
        map.values = integers_to_px(*bytes, config.scale, config);
    } else if (const auto* wide = std::get_if<std::vector<std::uint16_t>>(&raster.samples)) {
        map.values = integers_to_px(*wide, given ? config.scale : kKittiScale, config);
    } else {
        auto& floats = std::get<std::vector<float>>(raster.samples);
        check_byte_order(floats, path);
        map.values = floats_to_px(std::move(floats), given ? config.scale : 1, config);
    }
    if (std::none_of(map.values.begin(), map.values.end(), DisparityMap::known)) {
        codec::refuse(path, "no pixel of the map is known; check the file and " + config.unknown_option);
    }
    return map;
}

}  // namespace hexrelief
