#include "pipeline/readers/depth/describe_map.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <type_traits>
#include <vector>

#include "pipeline/data/error.h"
#include "pipeline/readers/codecs.h"
#include "pipeline/readers/depth/depth_reader.h"
#include "pipeline/readers/disparity_reader.h"

namespace hexrelief::readers {
namespace {

std::string number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.4g", value);
    return text;
}

// Returns "0.52 .. 7.31 m, 93.1 % known"; unknown values are infinite.
std::string extent(const std::vector<float>& values, const char* unit) {
    float least = kUnknownDisparity, largest = 0;
    std::size_t known = 0;
    for (const float value : values) {
        if (!std::isfinite(value)) continue;
        ++known;
        least = std::min(least, value);
        largest = std::max(largest, value);
    }
    return number(least) + " .. " + number(largest) + unit + ", " +
           number(100.0 * static_cast<double>(known) / static_cast<double>(values.size())) + " % known";
}

// Returns the result of text(), or the reason why it refuses the file.
template <typename Text>
std::string said_or_refused(const std::filesystem::path& path, Text text) {
    try {
        return text();
    } catch (const Error& error) {
        const std::string opening = "cannot read '" + path.string() + "': ", what = error.what();
        return "refused: " + (what.starts_with(opening) ? what.substr(opening.size()) : what);
    }
}

// Names the interpretation of disparity_reader for samples without a scale.
std::string disparities_believed(const codec::Raster& raster) {
    return std::holds_alternative<std::vector<float>>(raster.samples) ? "floats, px"
                                                                      : "16-bit integers, KITTI's 1/256 px";
}

template <typename Samples>
void describe_samples(const Samples& samples, double nodata, MapDescription& map) {
    std::size_t known = 0;
    for (const auto sample : samples) {
        const auto value = static_cast<double>(sample);
        if (!std::isfinite(value) || value <= 0 || value == nodata) continue;
        map.least = known == 0 ? value : std::min(map.least, value);
        map.largest = std::max(map.largest, value);
        ++known;
    }
    map.known_share = static_cast<double>(known) / static_cast<double>(samples.size());
    map.may_be_mask = !std::is_floating_point_v<typename Samples::value_type> && map.least == map.largest;
}

}  // namespace

MapDescription describe_map(const std::filesystem::path& path, const std::string& key,
                            const ReaderLimits& limits) {
    const codec::Raster raster = codec::read_map_raster(path, {"a map", "samples"}, key, limits);
    MapDescription map;
    std::visit([&](const auto& samples) { describe_samples(samples, raster.nodata, map); }, raster.samples);
    map.as_depth = said_or_refused(path, [&] {
        const DepthFile file = depths_of(raster, path, {});
        return file.believed + ": " + extent(file.map.values, " m");
    });
    map.as_disparity = said_or_refused(path, [&] {
        const DisparityMap disparities = disparities_of(raster, path, {});
        return disparities_believed(raster) + ": " + extent(disparities.values, " px");
    });
    return map;
}

}  // namespace hexrelief::readers
