#include "pipeline/job/maps/disparity_input.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <type_traits>
#include <utility>

#include "exporters/images/resize.h"
#include "pipeline/data/error.h"
#include "pipeline/data/number_text.h"
#include "pipeline/stages/depth.h"

namespace hexrelief::job {
namespace {

// Share of the known disparities beyond infinity that matchers leave by mistake.
constexpr double kFewBeyond = 0.05;
// Largest disparity, as a share of the width, below which an assumed scale of integers is doubted.
constexpr double kSmallest = 0.015, kLargest = 0.6;
constexpr double kStereoSgbm = 16, kAssumed = 256;

constexpr const char* kAdvice =
    "--disparity-scale -1 turns the sign of all, --disparity-offset PX moves them (input.disparity.scale, "
    "input.disparity.offset_px)";

// Returns the disparity that one in a hundred exceeds.
double usual_largest(const DisparityMap& map) {
    std::vector<float> known = known_values(map);
    return known.empty() ? 0 : value_at_rank(known, known.size() * 99 / 100);
}

// Returns the warning of an assumed scale, if the disparities are small and StereoSGBM's scale would be
// usual.
std::vector<std::string> doubts(const DisparityMap& map) {
    const double largest = usual_largest(map), other = largest * kAssumed / kStereoSgbm;
    if (largest >= kSmallest * map.width || other < kSmallest * map.width || other > kLargest * map.width)
        return {};
    return {"the map's disparities go up to " + number_text(largest, 3) +
            " px only, if KITTI's scale of 256 is right, which was assumed; with OpenCV's 1/16 px up to " +
            number_text(other, 3) + " px: give --disparity-scale 16 or 256 (input.disparity.scale)"};
}

// Returns the share of known pixels and their range of depths. Throws Error(input) if none is known.
std::string extent_text(const DepthMap& map) {
    float nearest = kUnknownDepth, farthest = 0;
    std::size_t known = 0;
    for (const float depth : map.values) {
        if (!DepthMap::known(depth)) continue;
        ++known;
        nearest = std::min(nearest, depth);
        farthest = std::max(farthest, depth);
    }
    if (known == 0)
        throw Error(ErrorKind::input,
                    "no depth lies between input.depth.near_m and input.depth.far_m; check them and the "
                    "map's unit (--depth-unit)");
    return number_text(100.0 * static_cast<double>(known) / static_cast<double>(map.values.size()), 4) +
           " % known, " + number_text(nearest, 4) + " to " + number_text(farthest, 4) +
           (map.metric ? " m" : " (relative)");
}

constexpr double kLargestStretch = 0.03;
// Stereo networks pad to these; those of single pictures resize to multiples of 14.
constexpr int kMultiples[] = {8, 16, 32, 64, 128};

bool is_padded(int map_width, int map_height, int width, int height) {
    return std::ranges::any_of(kMultiples, [&](int multiple) {
        const auto is_next = [&](int side, int of) {
            return side % multiple == 0 && side >= of && side - of < multiple;
        };
        return is_next(map_width, width) && is_next(map_height, height);
    });
}

std::vector<std::uint8_t>& pixels_of(readers::PixelMask& mask) {
    return mask.kept;
}
template <typename Map>
std::vector<float>& pixels_of(Map& map) {
    return map.values;
}

// Takes the pixels of a window of `width` columns from `left` on, with these rows.
template <typename Map, typename RowOf>
void take(Map& map, int left, int width, int height, RowOf row_of) {
    auto& stored = pixels_of(map);
    std::remove_reference_t<decltype(stored)> values;
    values.reserve(static_cast<std::size_t>(width) * height);
    for (int y = 0; y < height; ++y) {
        const auto row = stored.begin() + static_cast<std::ptrdiff_t>(row_of(y)) * map.width + left;
        values.insert(values.end(), row, row + width);
    }
    stored = std::move(values);
    map.width = width;
    map.height = height;
}

template <typename Map>
std::string fitted(Map& map, int width, int height) {
    const std::string before = "the map's " + size_text(map.width, map.height) + " px ";
    const double fitting = 1.0 * map.width * height / width;  // rows
    if (std::abs(fitting - map.height) <= 1 || std::abs(1.0 * map.height * width / height - map.width) <= 1)
        return {};
    if (is_padded(map.width, map.height, width, height)) {
        const int left = (map.width - width) / 2, top = (map.height - height) / 2;
        take(map, left, width, height, [&](int y) { return y + top; });
        return before + "are taken for the picture's " + size_text(width, height) +
               " px padded on all sides, and cut; a map that was padded otherwise has to be cut before";
    }
    if (std::abs(fitting / map.height - 1) > kLargestStretch) return {};
    const int rows = std::max(1, static_cast<int>(std::lround(fitting))), stored = map.height;
    take(map, 0, map.width, rows,
         [&](int y) { return static_cast<int>((2LL * y + 1) * stored / (2LL * rows)); });
    return before + "differ from the aspect of the picture's " + size_text(width, height) +
           " px, as a network rounds sides: stretched to " + size_text(map.width, map.height) + " px";
}

}  // namespace

std::vector<std::string> keep_in_front(readers::DisparityFile& file, double doffs_px) {
    const KnownRange range = known_range(file.map);
    std::size_t known = 0, beyond = 0;
    for (float& d : file.map.values) {
        if (!DisparityMap::known(d)) continue;
        ++known;
        if (d + doffs_px > 0) continue;
        ++beyond;
        d = kUnknownDisparity;
    }
    if (known > 0 && beyond == known)
        throw Error(ErrorKind::input, "the map's disparities go from " + number_text(range.least, 3) +
                                          " to " + number_text(range.largest, 3) + " px, none above " +
                                          number_text(0 - doffs_px, 3) + " px, so none has a depth; " +
                                          kAdvice);
    std::vector<std::string> warnings;
    if (file.is_scale_assumed) warnings = doubts(file.map);
    const double share = static_cast<double>(beyond) / static_cast<double>(std::max<std::size_t>(known, 1));
    if (share > kFewBeyond)
        warnings.push_back(number_text(100 * share, 3) + " % of the map's disparities are " +
                           number_text(0 - doffs_px, 3) + " px or less and become unknown; " + kAdvice);
    return warnings;
}

DepthInput take_depths(readers::DepthFile file, const readers::DepthFileConfig& config, bool is_focal_known,
                       Calibration& camera) {
    DepthMap& map = file.map;
    DepthInput input;
    if (config.ray) stages::project_on_axis(map, camera);
    stages::keep_between(map, config.near_m, config.far_m);
    input.decisions.push_back("depth: " + file.believed + "; " + extent_text(map));
    camera.metric = map.metric && is_focal_known;
    if (!(camera.baseline_m > 0) || !map.metric) {
        camera.baseline_m = stages::baseline_for(map, camera.focal_px);
        camera.doffs_px = 0;
        input.is_baseline_chosen = true;
        input.decisions.push_back("depth: taken as disparities of a baseline of " +
                                  number_text(camera.baseline_m, 4) + (map.metric ? " m" : " (relative)") +
                                  ", chosen by the nearest distance");
    }
    input.map = stages::disparities_of(map, camera);
    return input;
}

std::string fit_to_picture(DisparityMap& map, int width, int height) {
    return fitted(map, width, height);
}

std::string fit_to_picture(DepthMap& map, int width, int height) {
    return fitted(map, width, height);
}

std::string fit_to_picture(readers::PixelMask& mask, int width, int height) {
    return fitted(mask, width, height);
}

ViewPicture picture_of_view(Image image, const std::filesystem::path& path, ViewSize view,
                            const std::filesystem::path& map_path) {
    const ViewSize size{image.width, image.height};
    if (!same_aspect(size, view))
        throw Error(ErrorKind::input, path.string() + ": the colour image has " + size_text(size) +
                                          " px, but the map " + map_path.string() + " has " +
                                          size_text(view) +
                                          "; both must show the same view, with the same aspect");
    if (size == view) return {std::move(image)};
    Image color = exporters::resized(image, view.width, view.height);
    return {std::move(color), std::move(image)};
}

readers::PixelMask fitted(readers::PixelMask mask, ViewSize view, const Image& picture,
                          const std::filesystem::path& path) {
    if (!picture.empty()) fit_to_picture(mask, picture.width, picture.height);
    const ViewSize size{mask.width, mask.height};
    if (size == view) return mask;
    if (!same_aspect(size, view))
        throw Error(ErrorKind::input, path.string() + ": it has " + size_text(size) + " px, but the view " +
                                          size_text(view) +
                                          "; both must show the left view, with the same aspect");
    return readers::resampled(mask, view.width, view.height);
}

void hide(std::vector<float>& values, const readers::PixelMask& mask) {
    for (std::size_t i = 0; i < mask.kept.size(); ++i)
        if (!mask.kept[i]) values[i] = kUnknownDisparity;
}

void hide(DisparityMap& map, const readers::PixelMask& mask) {
    hide(map.values, mask);
    for (std::size_t i = 0; i < map.origins.size(); ++i)
        if (!DisparityMap::known(map.values[i])) map.origins[i] = PixelOrigin::unknown;
}

readers::PixelMask opaque_part(const Image& image) {
    readers::PixelMask mask{image.width, image.height, image.alpha};
    for (std::uint8_t& kept : mask.kept) kept = kept >= kOpaque;
    if (!mask.empty() && std::ranges::find(mask.kept, 1) == mask.kept.end())
        throw Error(
            ErrorKind::input,
            "every pixel of the left picture is transparent, so nothing is known; set input.mask.alpha "
            "to false where its alpha means nothing");
    return mask;
}

readers::PixelMask both(readers::PixelMask a, const readers::PixelMask& b) {
    if (a.empty()) return b;
    for (std::size_t i = 0; i < b.kept.size(); ++i) a.kept[i] &= b.kept[i];
    return a;
}

std::string percent_text(const readers::PixelMask& mask, std::uint8_t value) {
    return fixed(100.0 * static_cast<double>(std::ranges::count(mask.kept, value)) /
                     static_cast<double>(mask.kept.size()),
                 1);
}

}  // namespace hexrelief::job
