#include "pipeline/readers/depth/describe_map.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "pipeline/data/error.h"
#include "pipeline/data/number_text.h"
#include "pipeline/readers/codecs.h"
#include "pipeline/readers/depth/depth_reader.h"
#include "pipeline/readers/disparity_reader.h"

namespace hexrelief::readers {
namespace {

struct Extent {
    double least = 0, largest = 0, known_share = 0;
};

Extent extent_of(const std::vector<float>& values) {
    Extent extent{kUnknownDisparity, -kUnknownDisparity, 0};
    std::size_t known = 0;
    for (const float value : values) {
        if (!std::isfinite(value)) continue;
        ++known;
        extent.least = std::min<double>(extent.least, value);
        extent.largest = std::max<double>(extent.largest, value);
    }
    extent.known_share = static_cast<double>(known) / static_cast<double>(values.size());
    return extent;
}

// Returns "0.52 .. 7.31 m, 93.1 % known".
std::string text_of(const Extent& extent, const char* unit) {
    return number_text(extent.least, 4) + " .. " + number_text(extent.largest, 4) + unit + ", " +
           number_text(100 * extent.known_share, 4) + " % known";
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

// The depths that cameras, renderers and networks give, and the disparities of rectified pairs.
constexpr double kNearest_m = 0.05, kFarthest_m = 1000;
constexpr double kLeastShare = 0.01, kLargestShare = 0.6;  // of the width, for the largest disparity

// Calls read(), and adds its line if the file is not refused and its values are usual.
template <typename Read>
void add_if_usual(std::vector<std::string>& lines, const std::string& option, Read read) {
    try {
        if (const std::string text = read(); !text.empty()) lines.push_back(option + ": " + text);
    } catch (const Error&) {
        return;  // the first line says what the file lacks
    }
}

void add_depths(const codec::Raster& raster, const std::filesystem::path& path, const char* option,
                const DepthFileConfig& config, std::vector<std::string>& lines) {
    add_if_usual(lines, option, [&]() -> std::string {
        const Extent extent = extent_of(depths_of(raster, path, config).map.values);
        const bool is_usual = extent.least >= kNearest_m && extent.largest <= kFarthest_m;
        return is_usual ? text_of(extent, " m") : "";
    });
}

void add_disparities(const codec::Raster& raster, const std::filesystem::path& path, double scale,
                     std::vector<std::string>& lines) {
    add_if_usual(lines, "--disparity-scale " + number_text(scale, 4), [&]() -> std::string {
        const Extent extent = extent_of(disparities_of(raster, path, {.scale = scale}).map.values);
        const bool is_usual =
            extent.largest >= kLeastShare * raster.width && extent.largest <= kLargestShare * raster.width;
        return is_usual ? text_of(extent, " px") : "";
    });
}

// The readings of maps by options: their units are those of known programs and data sets.
void describe_readings(const codec::Raster& raster, const std::filesystem::path& path, MapDescription& map) {
    map.as_depth.push_back(said_or_refused(path, [&] {
        const DepthFile file = depths_of(raster, path, {});
        return file.believed + ": " + text_of(extent_of(file.map.values), file.map.metric ? " m" : "");
    }));
    map.as_disparity.push_back(said_or_refused(path, [&] {
        const DisparityFile file = disparities_of(raster, path, {});
        return file.believed + ": " + text_of(extent_of(file.map.values), " px");
    }));
    if (raster.stated.kind != codec::StatedDepth::Kind::nothing) return;
    if (raster.are_floats()) {
        add_depths(raster, path, "--depth-unit mm", {.unit = "mm"}, map.as_depth);
        add_depths(raster, path, "--depth-kind inverse_depth", {.kind = DepthKind::inverse_depth},
                   map.as_depth);
        add_disparities(raster, path, -1, map.as_disparity);
        return;
    }
    if (std::holds_alternative<std::vector<std::uint8_t>>(raster.samples)) {
        for (const double scale : {1, 2, 3, 4, 8, 16}) add_disparities(raster, path, scale, map.as_disparity);
        return;
    }
    add_depths(raster, path, "--depth-unit 100", {.unit = "100"}, map.as_depth);
    add_depths(raster, path, "--depth-unit 256", {.unit = "256"}, map.as_depth);
    add_depths(raster, path, "--depth-unit 5000", {.unit = "5000"}, map.as_depth);
    for (const double scale : {1, 16, 100, 256}) add_disparities(raster, path, scale, map.as_disparity);
}

template <typename Samples>
void describe_samples(const Samples& samples, double nodata, MapDescription& map) {
    std::size_t known = 0;
    for (const auto sample : samples) {
        const auto value = static_cast<double>(sample);
        if (!std::isfinite(value) || value == 0 || value == nodata) continue;
        map.least = known == 0 ? value : std::min(map.least, value);
        map.largest = known == 0 ? value : std::max(map.largest, value);
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
    describe_readings(raster, path, map);
    return map;
}

}  // namespace hexrelief::readers
