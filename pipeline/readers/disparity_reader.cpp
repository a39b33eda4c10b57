#include "pipeline/readers/disparity_reader.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/data/error.h"
#include "pipeline/readers/codecs.h"

namespace hexrelief::readers {
namespace {

constexpr double kKittiScale = 256;

void check_config(const DisparityFileConfig& config) {
    const std::string outside =
        out_of_range({{"input.disparity.scale", config.scale, DisparityFileConfig::kScale},
                      {"input.disparity.offset_px", config.offset_px, DisparityFileConfig::kOffset_px}});
    if (!outside.empty()) throw Error(ErrorKind::usage, outside);
}

float usable(double disparity) {
    return std::abs(disparity) <= kLargestDisparity_px ? static_cast<float>(disparity) : kUnknownDisparity;
}

template <typename Sample>
std::vector<float> integers_to_px(const std::vector<Sample>& samples, double nodata, double scale,
                                  const DisparityFileConfig& config) {
    const double unknown = std::isnan(config.unknown) ? 0 : config.unknown;
    std::vector<float> values(samples.size());
    std::transform(samples.begin(), samples.end(), values.begin(), [&](Sample raw) {
        return raw == unknown || raw == nodata ? kUnknownDisparity : usable(raw / scale + config.offset_px);
    });
    return values;
}

std::vector<float> floats_to_px(std::vector<float> samples, double nodata, double scale,
                                const DisparityFileConfig& config) {
    const auto unknown = static_cast<float>(config.unknown), none = static_cast<float>(nodata);
    // True for most maps; this loop is then all that is done.
    const bool as_stored = scale == 1 && config.offset_px == 0;
    const float most =
        as_stored ? static_cast<float>(kLargestDisparity_px) : std::numeric_limits<float>::max();
    for (float& sample : samples) {
        const bool known = (sample > 0) & (sample <= most) & (sample != unknown) & (sample != none);
        sample = known ? sample : kUnknownDisparity;
    }
    if (!as_stored)
        for (float& sample : samples)
            if (DisparityMap::known(sample)) sample = usable(sample / scale + config.offset_px);
    return samples;
}

[[noreturn]] void refuse_missing_scale(const std::filesystem::path& path, const std::string& option) {
    codec::refuse(path, "an 8-bit disparity map does not say how many grey levels are one pixel; give " +
                            option +
                            ". Middlebury's scales: 2001 sets 8 (tsukuba 16); 2003 quarter size 4, half 2, "
                            "full 1; 2005/2006 third size 3, half 2, full 1");
}

}  // namespace

DisparityMap read_disparity_map(const std::filesystem::path& path, const DisparityFileConfig& config,
                                const ReaderLimits& limits) {
    check_config(config);
    return disparities_of(
        codec::read_map_raster(path, {"a disparity map", "disparities"}, config.key, limits), path, config);
}

DisparityMap disparities_of_part(codec::Raster raster, const std::filesystem::path& path,
                                 const DisparityFileConfig& config) {
    check_config(config);
    if (raster.stated.kind != codec::StatedDepth::Kind::nothing)
        codec::refuse(path, "it holds depths, not disparities; give it by --depth");
    DisparityMap map;
    map.width = raster.width;
    map.height = raster.height;
    const bool given = config.scale > 0;
    if (const auto* bytes = std::get_if<std::vector<std::uint8_t>>(&raster.samples)) {
        if (!given) refuse_missing_scale(path, config.scale_option);
        map.values = integers_to_px(*bytes, raster.nodata, config.scale, config);
    } else if (const auto* wide = std::get_if<std::vector<std::uint16_t>>(&raster.samples)) {
        map.values = integers_to_px(*wide, raster.nodata, given ? config.scale : kKittiScale, config);
    } else {
        auto& floats = std::get<std::vector<float>>(raster.samples);
        map.values = floats_to_px(std::move(floats), raster.nodata, given ? config.scale : 1, config);
    }
    return map;
}

DisparityMap disparities_of(codec::Raster raster, const std::filesystem::path& path,
                            const DisparityFileConfig& config) {
    DisparityMap map = disparities_of_part(std::move(raster), path, config);
    if (std::none_of(map.values.begin(), map.values.end(), DisparityMap::known)) {
        codec::refuse(path,
                      "no pixel of the map is known, with a disparity of at most a million px; check the "
                      "file, " +
                          config.unknown_option + " and " + config.scale_option);
    }
    return map;
}

}  // namespace hexrelief::readers
