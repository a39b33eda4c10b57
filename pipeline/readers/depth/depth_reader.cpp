#include "pipeline/readers/depth/depth_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <vector>

#include "pipeline/data/error.h"
#include "pipeline/data/number_text.h"
#include "pipeline/readers/codecs.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::readers {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
// The assumed ratio of depths if nothing says how far a network's relative depths reach.
constexpr double kFarthestToNearest = 10;
// Share of the samples at either end that are ignored when the ends are determined.
constexpr double kOutlierShare = 0.002;

// Renderers write 1e10 for pixels where no surface is hit.
constexpr double kSky_m = 1e9;

// The samples as floats; those that mean "unknown" are NaN.
struct Samples {
    std::vector<float> values;
    bool are_bytes = false, are_integers = true;
    double step = are_integers ? 1 : 0;
};

bool is_affine(DepthKind kind) {
    return kind == DepthKind::affine_inverse || kind == DepthKind::affine_depth;
}

// Returns the largest number of the raster's type of integers, which cameras write for "too far".
double largest_integer(const codec::Raster& raster) {
    if (raster.integer_bits == 0) return 65535;
    return std::ldexp(1.0, raster.integer_bits - (raster.is_signed ? 1 : 0)) - 1;
}

template <typename Sample>
std::vector<float> without(const std::vector<Sample>& raw, std::array<double, 3> unknown) {
    std::array<float, 3> none;
    std::copy(unknown.begin(), unknown.end(), none.begin());
    std::vector<float> values(raw.size());
    std::transform(raw.begin(), raw.end(), values.begin(), [&](Sample sample) {
        const auto value = static_cast<float>(sample);
        const bool known = std::isfinite(value) && std::ranges::find(none, value) == none.end();
        return known ? value : static_cast<float>(kNone);
    });
    return values;
}

Samples samples_of(const codec::Raster& raster, const DepthFileConfig& config) {
    const bool given = !std::isnan(config.unknown);
    const double of_integers = given || is_affine(config.kind) ? config.unknown : 0,
                 largest = config.kind == DepthKind::depth && !given ? largest_integer(raster) : kNone;
    if (const auto* bytes = std::get_if<std::vector<std::uint8_t>>(&raster.samples))
        return {without(*bytes, {of_integers, raster.nodata, kNone}), true};
    if (const auto* wide = std::get_if<std::vector<std::uint16_t>>(&raster.samples))
        return {without(*wide, {of_integers, raster.nodata, largest})};
    const auto& floats = std::get<std::vector<float>>(raster.samples);
    if (raster.integer_bits > 0) return {without(floats, {of_integers, raster.nodata, largest})};
    return {without(floats, {config.unknown, raster.nodata, kNone}), false, false};
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

Unit unit_of(const std::filesystem::path& path, const Samples& samples, const DepthFileConfig& config,
             double said_per_m) {
    if (!config.unit.empty()) return parse_unit(config.unit).value();
    if (!samples.are_integers || is_affine(config.kind)) return {1, "m"};
    if (config.kind == DepthKind::inverse_depth)
        codec::refuse(path,
                      "integers of inverse depth do not say how many are one over a metre; give --depth-unit "
                      "(input.depth.unit)");
    if (said_per_m > 0)
        return {said_per_m, (said_per_m == 1000 ? "mm" : "1/" + number_text(said_per_m, 6) + " m") +
                                std::string(", as the calibration file says")};
    if (samples.are_bytes)
        codec::refuse(path,
                      "an 8-bit depth map does not say how many of its levels are a metre; give --depth-unit "
                      "(input.depth.unit), or --depth-kind affine_inverse for the picture of a network's "
                      "output");
    return {1000, "mm"};
}

// The coefficients of shift + scale * sample, which is the depth or 1 / depth.
struct Affine {
    double shift, scale;
    bool is_given = true;
};

// Returns the given coefficients, or those by which the samples, without outliers, go from 1 / 10 to 1 for
// affine_inverse and from 1 to 10 for affine_depth.
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
        std::ranges::nth_element(known, known.begin() + rank);
        return static_cast<double>(known[rank]);
    };
    const double least = at(cut), largest = at(static_cast<std::ptrdiff_t>(known.size()) - 1 - cut);
    if (!(largest > least)) return {1, 0, false};
    const double top = config.kind == DepthKind::affine_depth ? kFarthestToNearest : 1;
    const double scale = (top - top / kFarthestToNearest) / (largest - least);
    return {top - scale * largest, scale, false};
}

float usable(double depth) {
    return depth > 0 && depth < kSky_m ? static_cast<float>(depth) : kUnknownDepth;  // NaN is not above 0
}

// Describes the assumed meaning of samples: "mm", "depth = 0.5 + 2 * sample, m".
std::string believed(const Affine& affine, const Unit& unit, DepthKind kind) {
    if (kind == DepthKind::depth) return unit.name;
    if (kind == DepthKind::inverse_depth) return "inverse depth, 1/(" + unit.name + ")";
    const bool is_inverse = kind == DepthKind::affine_inverse;
    const std::string value =
        number_text(affine.shift, 6) + " + " + number_text(affine.scale, 6) + " * sample";
    const std::string depth = "depth = " + (is_inverse ? "1 / (" + value + ")" : value) + ", ";
    if (affine.is_given) return depth + unit.name;
    return depth + "relative, the " + (is_inverse ? "largest" : "smallest") +
           " samples nearest (if farthest: --depth-kind " + (is_inverse ? "affine_depth" : "affine_inverse") +
           ")";
}

DepthFile to_depths(Samples samples, const Unit& unit, const DepthFileConfig& config) {
    const bool is_inverse =
        config.kind == DepthKind::inverse_depth || config.kind == DepthKind::affine_inverse;
    const Affine affine = is_affine(config.kind) ? affine_of(samples.values, config) : Affine{0, 1};
    // Samples in 1 / mm are thousandths of those in 1 / m; a given number divides the samples.
    const bool divides = config.kind == DepthKind::inverse_depth && unit.name != "mm";
    const double per_m = !affine.is_given ? 1 : divides ? 1 / unit.per_m : unit.per_m;
    for (float& sample : samples.values) {
        const double value = affine.shift + affine.scale * sample;
        sample = usable(is_inverse ? 1 / (value * per_m) : value / per_m);
    }
    const double step = samples.step * std::abs(affine.scale);
    return {.map = {.values = std::move(samples.values),
                    .metric = affine.is_given,
                    .step = is_inverse ? step * per_m : step / per_m,
                    .is_inverse = is_inverse},
            .believed = believed(affine, unit, config.kind)};
}

// Returns a warning if floats that are taken for metres are whole numbers as large as millimetres.
std::string doubt_of(const Samples& samples, const DepthFileConfig& config) {
    constexpr float far_m = 200;
    if (samples.are_integers || config.kind != DepthKind::depth || !config.unit.empty()) return {};
    float largest = 0;
    for (const float sample : samples.values) {
        if (std::isnan(sample)) continue;
        if (sample != std::floor(sample)) return {};
        largest = std::max(largest, sample);
    }
    if (largest < far_m || largest >= kSky_m) return {};
    return "the depths are whole numbers up to " + number_text(largest, 6) +
           ", read as metres; if they are millimetres, give --depth-unit mm (input.depth.unit)";
}

// Returns a warning if 16-bit integers that are taken for mm are all multiples of 8, but not all of 16. Few
// different ones tell nothing.
std::string doubt_of_bits(const codec::Raster& raster, const DepthFileConfig& config, double said_per_m) {
    constexpr int kLeastDifferent = 64;
    const auto* const samples = std::get_if<std::vector<std::uint16_t>>(&raster.samples);
    if (!samples || config.kind != DepthKind::depth || !config.unit.empty() || said_per_m > 0) return {};
    std::uint16_t bits = 0;
    std::vector<bool> is_there(1 << 16);
    for (const std::uint16_t sample : *samples) {
        bits |= sample;
        is_there[sample] = true;
    }
    if (bits % 16 != 8 || std::ranges::count(is_there, true) < kLeastDifferent) return {};
    return "all depths are multiples of 8, as those of SUN RGB-D, which has millimetres with their bits "
           "turned by three; if they are its, --depth-unit 8000 reads them (input.depth.unit)";
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
                         const ReaderLimits& limits, double said_per_m) {
    if (const std::string wrong = wrong_depth_config(config); !wrong.empty())
        throw Error(ErrorKind::usage, wrong);
    return depths_of(
        codec::read_map_raster(path, {.map = "a depth map", .samples = "depths", .packing = config.packing},
                               config.key, limits),
        path, config, said_per_m);
}

DepthFile depths_of(const codec::Raster& raster, const std::filesystem::path& path,
                    const DepthFileConfig& given, double said_per_m) {
    const DepthFileConfig config = with_stated(given, raster.stated);
    Samples samples = samples_of(raster, config);
    if (raster.stated.step > 0) samples.step = raster.stated.step;
    const std::string name = raster.stated.told.empty() ? codec::samples_name(raster) : raster.stated.told;
    const Unit unit = unit_of(path, samples, config, said_per_m);
    std::string doubt = raster.stated.told.empty() ? doubt_of(samples, config) : "";
    if (doubt.empty()) doubt = doubt_of_bits(raster, config, said_per_m);
    DepthFile file = to_depths(std::move(samples), unit, config);
    file.believed = name + ", " + file.believed;
    file.doubt = doubt;
    if (raster.stated.kind == codec::StatedDepth::Kind::relative_depth && given.unit.empty()) {
        file.map.metric = false;
        file.believed = name + ", in units of the reconstruction";
    }
    if (config.flip) codec::flip_rows(file.map.values, raster.width);
    file.map.width = raster.width;
    file.map.height = raster.height;
    if (std::ranges::none_of(file.map.values, DepthMap::known))
        codec::refuse(path,
                      "no pixel of the map is known; check the file, --depth-kind (input.depth.kind) and "
                      "--unknown (input.depth.unknown)");
    return file;
}

}  // namespace hexrelief::readers
