#include "pipeline/readers/disparity_reader.h"

#include <algorithm>
#include <cmath>

#include "pipeline/data/error.h"
#include "pipeline/data/number_text.h"
#include "pipeline/readers/codecs.h"

namespace hexrelief::readers {
namespace {

constexpr double kKittiScale = 256, kStereoSgbmScale = 16;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

void check_config(const DisparityFileConfig& config) {
    const std::string outside =
        out_of_range({{"input.disparity.scale", config.scale, DisparityFileConfig::kScale},
                      {"input.disparity.offset_px", config.offset_px, DisparityFileConfig::kOffset_px}});
    if (!outside.empty()) throw Error(ErrorKind::usage, outside);
}

// The conversion of samples to px, without the offset.
struct Meaning {
    double scale = 1;
    double unknown = 0;
    const char* whose = "";  // " as KITTI's", if the scale is assumed
};

// The samples of a raster that are below 0.
struct Negatives {
    double least = 0;  // 0 = there are none
    bool are_one_value = true;
    bool is_least_alone = true;  // by one px of StereoSGBM in integers, and more than one px in floats
    bool is_least_usual = false;
};

Negatives negatives_of(const codec::Raster& raster) {
    const auto& samples = std::get<std::vector<float>>(raster.samples);
    const auto none = static_cast<float>(raster.nodata);
    float least = 0, largest = -std::numeric_limits<float>::infinity();
    for (const float v : samples)
        if (v < 0 && std::isfinite(v) && v != none) {
            least = std::min(least, v);
            largest = std::max(largest, v);
        }
    if (least == 0) return {};
    const float next =
        raster.are_floats() ? std::nextafter(least + 1, 0.0f) : least + static_cast<float>(kStereoSgbmScale);
    std::size_t equal = 0, near = 0;
    for (const float v : samples) {
        equal += v == least;
        near += v > least && v < next && v != none;
    }
    return {least, least == largest, near == 0, equal > 1 && equal >= samples.size() / 1000};
}

// Finds the sample that means "unknown" where none is given, and StereoSGBM's scale.
Meaning meaning_of_floats(const codec::Raster& raster) {
    const Negatives below = negatives_of(raster);
    // StereoSGBM writes 16 times the px, and below the least that it searched where it found nothing.
    const bool is_sgbm = raster.integer_bits == 16 && raster.is_signed && below.is_least_alone &&
                         std::fmod(below.least, kStereoSgbmScale) == 0;
    if (is_sgbm) return {kStereoSgbmScale, below.least, " as StereoSGBM's"};
    const bool is_unknown = below.are_one_value || (below.is_least_alone && below.is_least_usual);
    return {raster.are_floats() ? 1 : kNone, is_unknown ? below.least : kNone};
}

// Gives StereoSGBM's samples their sign back if the map was saved as unsigned: what was not found, -16 or
// another negative multiple of 16, is then 65520 or less, on many pixels, and no sample lies far below it.
void restore_signs(codec::Raster& raster) {
    constexpr std::uint16_t least_negative = 0x8000, least_unknown = 0xf000;
    const auto* const words = std::get_if<std::vector<std::uint16_t>>(&raster.samples);
    if (!words) return;
    std::uint16_t lowest = 0xffff;
    for (const std::uint16_t word : *words)
        if (word >= least_negative) lowest = std::min(lowest, word);
    if (lowest < least_unknown || lowest % static_cast<int>(kStereoSgbmScale) != 0) return;
    const auto unknown = static_cast<std::size_t>(std::ranges::count(*words, lowest));
    if (unknown < 2 || unknown < words->size() / 1000) return;
    std::vector<float> values(words->size());
    std::ranges::transform(*words, values.begin(), [](std::uint16_t word) {
        return static_cast<float>(static_cast<std::int16_t>(word));
    });
    raster.samples = std::move(values);
    raster.integer_bits = 16;
    raster.is_signed = true;
    raster.stated.told = "16-bit integers that have lost their sign";
}

[[noreturn]] void refuse_missing_scale(const std::filesystem::path& path, const codec::Raster& raster,
                                       const std::string& option) {
    if (raster.integer_bits > 0)
        codec::refuse(path, "a disparity map of " + codec::samples_name(raster) +
                                " does not say how many are one pixel; give " + option +
                                ": 1 for whole pixels, 16 for OpenCV's");
    codec::refuse(path, "an 8-bit disparity map does not say how many grey levels are one pixel; give " +
                            option +
                            ". Middlebury's scales: 2001 sets 8 (tsukuba 16); 2003 quarter size 4, half 2, "
                            "full 1; 2005/2006 third size 3, half 2, full 1");
}

Meaning meaning_of(const std::filesystem::path& path, const codec::Raster& raster,
                   const DisparityFileConfig& config, bool is_part) {
    const bool is_wide = std::holds_alternative<std::vector<std::uint16_t>>(raster.samples);
    Meaning meaning;
    if (is_wide) meaning = {kKittiScale, 0, " as KITTI's"};
    if (std::holds_alternative<std::vector<std::uint8_t>>(raster.samples)) meaning.scale = kNone;
    if (!is_part && std::holds_alternative<std::vector<float>>(raster.samples))
        meaning = meaning_of_floats(raster);
    if (!std::isnan(config.unknown)) meaning.unknown = config.unknown;
    if (config.scale != 0) {
        meaning.scale = config.scale;
        meaning.whose = "";
    }
    if (std::isnan(meaning.scale)) refuse_missing_scale(path, raster, config.scale_option);
    return meaning;
}

float usable(double disparity, double beyond) {
    return disparity > beyond && std::abs(disparity) <= kLargestDisparity_px ? static_cast<float>(disparity)
                                                                             : kUnknownDisparity;
}

template <typename Sample>
std::vector<float> to_px(const std::vector<Sample>& samples, double nodata, const Meaning& meaning,
                         const DisparityFileConfig& config) {
    std::vector<float> values(samples.size());
    std::transform(samples.begin(), samples.end(), values.begin(), [&](Sample raw) {
        return raw == meaning.unknown || raw == nodata
                   ? kUnknownDisparity
                   : usable(raw / meaning.scale + config.offset_px, config.beyond_px);
    });
    return values;
}

std::vector<float> floats_to_px(std::vector<float> samples, double nodata, const Meaning& meaning,
                                const DisparityFileConfig& config) {
    const auto unknown = static_cast<float>(meaning.unknown), none = static_cast<float>(nodata);
    // True for most maps; this loop is then all that is done.
    const bool as_stored = meaning.scale == 1 && config.offset_px == 0;
    const auto beyond = static_cast<float>(config.beyond_px), most = static_cast<float>(kLargestDisparity_px);
    for (float& sample : samples) {
        const bool is_known = (sample != unknown) & (sample != none);
        if (as_stored)
            sample = is_known & (sample > beyond) & (sample <= most) & (sample >= -most) ? sample
                                                                                         : kUnknownDisparity;
        else
            sample = is_known && std::isfinite(sample)
                         ? usable(sample / meaning.scale + config.offset_px, config.beyond_px)
                         : kUnknownDisparity;
    }
    return samples;
}

std::string believed(const codec::Raster& raster, const Meaning& meaning, const DisparityFileConfig& config) {
    std::string text = (raster.stated.told.empty() ? codec::samples_name(raster) : raster.stated.told) + ", ";
    text += meaning.scale == 1    ? "px"
            : meaning.scale == -1 ? "px, sign turned"
            : meaning.scale > 0   ? "1/" + number_text(meaning.scale, 6) + " px"
                                  : "-1/" + number_text(-meaning.scale, 6) + " px";
    text += meaning.whose;
    if (config.offset_px != 0)
        text += (config.offset_px > 0 ? ", +" : ", ") + number_text(config.offset_px, 6) + " px";
    if (meaning.unknown < 0) text += ", " + number_text(meaning.unknown, 6) + " unknown";
    return text;
}

DisparityFile converted(codec::Raster raster, const std::filesystem::path& path,
                        const DisparityFileConfig& config, bool is_part) {
    check_config(config);
    if (raster.stated.kind != codec::StatedDepth::Kind::nothing)
        codec::refuse(path, "it holds depths, not disparities; give it by --depth");
    const Meaning meaning = meaning_of(path, raster, config, is_part);
    DisparityFile file{{raster.width, raster.height, {}}, believed(raster, meaning, config)};
    file.is_scale_assumed = *meaning.whose != 0;
    if (auto* const floats = std::get_if<std::vector<float>>(&raster.samples))
        file.map.values = floats_to_px(std::move(*floats), raster.nodata, meaning, config);
    else if (const auto* const bytes = std::get_if<std::vector<std::uint8_t>>(&raster.samples))
        file.map.values = to_px(*bytes, raster.nodata, meaning, config);
    else
        file.map.values =
            to_px(std::get<std::vector<std::uint16_t>>(raster.samples), raster.nodata, meaning, config);
    return file;
}

}  // namespace

DisparityFileConfig before_doffs(DisparityFileConfig config) {
    config.beyond_px = -kLargestDisparity_px;
    return config;
}

DisparityFile read_disparity_file(const std::filesystem::path& path, const DisparityFileConfig& config,
                                  const ReaderLimits& limits) {
    check_config(config);
    return disparities_of(
        codec::read_map_raster(
            path, {.map = "a disparity map", .samples = "disparities", .packing = config.packing}, config.key,
            limits),
        path, config);
}

DisparityMap read_disparity_map(const std::filesystem::path& path, const DisparityFileConfig& config,
                                const ReaderLimits& limits) {
    return read_disparity_file(path, config, limits).map;
}

DisparityMap disparities_of_part(codec::Raster raster, const std::filesystem::path& path,
                                 const DisparityFileConfig& config) {
    return converted(std::move(raster), path, config, true).map;
}

DisparityFile disparities_of(codec::Raster raster, const std::filesystem::path& path,
                             const DisparityFileConfig& config) {
    if (config.scale == 0 || config.scale == kStereoSgbmScale) restore_signs(raster);
    DisparityFile file = converted(std::move(raster), path, config, false);
    if (config.flip) codec::flip_rows(file.map.values, file.map.width);
    if (std::ranges::none_of(file.map.values, DisparityMap::known))
        codec::refuse(path, "no pixel of the map is known, with a disparity of at most a million px" +
                                std::string(config.beyond_px == 0 ? " and above 0" : "") +
                                "; check the file, " + config.unknown_option + " and " + config.scale_option +
                                ", which is -1 if the sign is turned");
    return file;
}

}  // namespace hexrelief::readers
