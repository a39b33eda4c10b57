#include "pipeline/readers/depth/depth_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <optional>
#include <vector>

#include "pipeline/data/error.h"
#include "pipeline/readers/codecs.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::readers {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kLargestWide = 65535;
// The assumed ratio of depths if nothing says how far a network's relative depths reach.
constexpr double kFarthestToNearest = 10;
// Share of the samples at either end that are ignored when the ends are determined.
constexpr double kOutlierShare = 0.002;

// Renderers write 1e10 for pixels where no surface is hit.
constexpr double kSky_m = 1e9;

std::string number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", value);
    return text;
}

// The samples as floats; those that mean "unknown" are NaN.
struct Samples {
    std::vector<float> values;
    int bits = 32;  // 8 and 16 are integers, 32 are floats

    bool are_integers() const { return bits < 32; }
    double step = are_integers() ? 1 : 0;

    std::string name() const { return are_integers() ? std::to_string(bits) + "-bit integers" : "floats"; }
};

template <typename Sample>
std::vector<float> without(const std::vector<Sample>& raw, std::array<double, 3> unknown) {
    std::array<float, 3> none;
    std::copy(unknown.begin(), unknown.end(), none.begin());
    std::vector<float> values(raw.size());
    std::transform(raw.begin(), raw.end(), values.begin(), [&](Sample sample) {
        const auto value = static_cast<float>(sample);
        const bool known = std::isfinite(value) && std::find(none.begin(), none.end(), value) == none.end();
        return known ? value : static_cast<float>(kNone);
    });
    return values;
}

Samples samples_of(const codec::Raster& raster, const DepthFileConfig& config) {
    const bool given = !std::isnan(config.unknown);
    const double zero = config.kind == DepthKind::affine_inverse ? kNone : 0,
                 of_integers = given ? config.unknown : zero,
                 largest = config.kind == DepthKind::depth && !given ? kLargestWide : kNone;
    if (const auto* bytes = std::get_if<std::vector<std::uint8_t>>(&raster.samples))
        return {without(*bytes, {of_integers, raster.nodata, kNone}), 8};
    if (const auto* wide = std::get_if<std::vector<std::uint16_t>>(&raster.samples))
        return {without(*wide, {of_integers, raster.nodata, largest}), 16};
    return {without(std::get<std::vector<float>>(raster.samples), {config.unknown, raster.nodata, kNone}),
            32};
}

struct Unit {
    double per_m;  // number of units in a metre
    std::string name;
};

std::optional<Unit> parse_unit(const std::string& text) {
    if (text == "m") return Unit{1, "m"};
    if (text == "mm") return Unit{1000, "mm"};
    const auto scale = codec::parse_number(text);
    if (!scale || !(*scale > 0)) return std::nullopt;
    return Unit{*scale, "1/" + text + " m"};
}

Unit unit_of(const std::filesystem::path& path, const Samples& samples, const DepthFileConfig& config) {
    if (!config.unit.empty()) return parse_unit(config.unit).value();
    if (!samples.are_integers() || config.kind == DepthKind::affine_inverse) return {1, "m"};
    if (config.kind == DepthKind::inverse_depth)
        codec::refuse(path,
                      "integers of inverse depth do not say how many are one over a metre; give --depth-unit "
                      "(input.depth.unit)");
    if (samples.bits == 8)
        codec::refuse(path,
                      "an 8-bit depth map does not say how many of its levels are a metre; give --depth-unit "
                      "(input.depth.unit), or --depth-kind affine_inverse for the picture of a network's "
                      "output");
    return {1000, "mm"};
}

// The coefficients of depth = 1 / (shift + scale * sample).
struct Affine {
    double shift, scale;
    bool is_given = true;
};

Affine affine_of(const std::vector<float>& samples, const DepthFileConfig& config) {
    const bool has_shift = !std::isnan(config.affine_shift), has_scale = !std::isnan(config.affine_scale);
    if (has_shift || has_scale)
        return {has_shift ? config.affine_shift : 0, has_scale ? config.affine_scale : 1};
    std::vector<float> known;
    known.reserve(samples.size());
    std::copy_if(samples.begin(), samples.end(), std::back_inserter(known),
                 [](float sample) { return !std::isnan(sample); });
    if (known.empty()) return {1, 0, false};
    const auto cut = static_cast<std::ptrdiff_t>(kOutlierShare * static_cast<double>(known.size()));
    const auto at = [&](std::ptrdiff_t rank) {
        std::nth_element(known.begin(), known.begin() + rank, known.end());
        return static_cast<double>(known[rank]);
    };
    const double farthest = at(cut), nearest = at(static_cast<std::ptrdiff_t>(known.size()) - 1 - cut);
    if (!(nearest > farthest)) return {1, 0, false};
    const double scale = (1 - 1 / kFarthestToNearest) / (nearest - farthest);
    return {1 - scale * nearest, scale, false};
}

float usable(double depth) {
    return depth > 0 && depth < kSky_m ? static_cast<float>(depth) : kUnknownDepth;  // NaN is not above 0
}

template <typename Formula>
std::vector<float> depths(std::vector<float> samples, Formula formula) {
    for (float& sample : samples) sample = usable(formula(static_cast<double>(sample)));
    return samples;
}

DepthFile from_depths(Samples samples, const Unit& unit) {
    DepthFile file;
    file.believed = unit.name;
    file.map.step = samples.step / unit.per_m;
    file.map.values = depths(std::move(samples.values), [&](double sample) { return sample / unit.per_m; });
    return file;
}

DepthFile from_inverse_depths(Samples samples, const Unit& unit) {
    // Samples in 1 / mm are thousandths of those in 1 / m; a given number divides the samples.
    const double scale = unit.name == "mm" ? unit.per_m : 1 / unit.per_m;
    DepthFile file;
    file.believed = "inverse depth, 1/(" + unit.name + ")";
    file.map.is_inverse = true;
    file.map.step = samples.step * scale;
    file.map.values = depths(std::move(samples.values), [&](double sample) { return 1 / (sample * scale); });
    return file;
}

DepthFile from_affine_inverse(Samples samples, const Unit& unit, const DepthFileConfig& config) {
    const Affine affine = affine_of(samples.values, config);
    const double per_m = affine.is_given ? unit.per_m : 1;
    DepthFile file;
    file.believed = "depth = 1 / (" + number(affine.shift) + " + " + number(affine.scale) + " * sample), " +
                    (affine.is_given ? unit.name : "relative");
    file.map.metric = affine.is_given;
    file.map.is_inverse = true;
    file.map.step = samples.step * std::abs(affine.scale) * per_m;
    file.map.values = depths(std::move(samples.values), [&](double sample) {
        const double inverse = affine.shift + affine.scale * sample;
        return inverse > 0 ? 1 / (inverse * per_m) : kNone;
    });
    return file;
}

DepthFile to_depths(Samples samples, const Unit& unit, const DepthFileConfig& config) {
    switch (config.kind) {
        case DepthKind::depth:
            return from_depths(std::move(samples), unit);
        case DepthKind::inverse_depth:
            return from_inverse_depths(std::move(samples), unit);
        case DepthKind::affine_inverse:
            return from_affine_inverse(std::move(samples), unit, config);
    }
    return {};
}

// Replaces the default kind by the kind that the file states.
DepthFileConfig with_stated(DepthFileConfig config, const codec::StatedDepth& stated) {
    using Kind = codec::StatedDepth::Kind;
    if (config.kind != DepthKind::depth) return config;
    if (stated.kind == Kind::inverse_depth) config.kind = DepthKind::inverse_depth;
    if (stated.kind == Kind::relative_inverse) config.kind = DepthKind::affine_inverse;
    return config;
}

}  // namespace

std::string wrong_depth_config(const DepthFileConfig& config) {
    if (!config.unit.empty() && !parse_unit(config.unit))
        return "input.depth.unit is " + codec::excerpt(config.unit) +
               "; it must be m, mm, or a number above 0 by which samples are divided to give metres";
    if (config.affine_scale == 0) return "input.depth.affine_scale is 0; no sample would then say anything";
    if (config.near_m > 0 && config.far_m > 0 && config.near_m >= config.far_m)
        return "input.depth.near_m must be below input.depth.far_m";
    return {};
}

DepthFile read_depth_map(const std::filesystem::path& path, const DepthFileConfig& config,
                         const ReaderLimits& limits) {
    if (const std::string wrong = wrong_depth_config(config); !wrong.empty())
        throw Error(ErrorKind::usage, wrong);
    return depths_of(codec::read_map_raster(path, {"a depth map", "depths"}, config.key, limits), path,
                     config);
}

DepthFile depths_of(const codec::Raster& raster, const std::filesystem::path& path,
                    const DepthFileConfig& given) {
    const DepthFileConfig config = with_stated(given, raster.stated);
    Samples samples = samples_of(raster, config);
    if (raster.stated.step > 0) samples.step = raster.stated.step;
    const std::string name = raster.stated.told.empty() ? samples.name() : raster.stated.told;
    const Unit unit = unit_of(path, samples, config);
    DepthFile file = to_depths(std::move(samples), unit, config);
    file.believed = name + ", " + file.believed;
    file.map.width = raster.width;
    file.map.height = raster.height;
    if (std::none_of(file.map.values.begin(), file.map.values.end(), DepthMap::known))
        codec::refuse(path,
                      "no pixel of the map is known; check the file, --depth-kind (input.depth.kind) and "
                      "--unknown (input.depth.unknown)");
    return file;
}

}  // namespace hexrelief::readers
