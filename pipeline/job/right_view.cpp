#include "pipeline/job/right_view.h"

#include <algorithm>
#include <utility>

#include "exporters/images/resize.h"
#include "pipeline/job/matchers/given_maps.h"
#include "pipeline/stages/densify/densify.h"
#include "pipeline/stages/dequantize/dequantize.h"
#include "pipeline/stages/dequantize/noise.h"

namespace hexrelief::job {
namespace {

using stages::OtherView;

// Holes of the right view are filled at a third of its size, or at this length if that is less.
constexpr int kFilled = 3, kFilled_px = 225;

// Returns the view whose map, seen in a mirror, is given.
OtherView right_view(DisparityMap mirrored, InputPair& pair, const stages::FoundRange& range, int threads) {
    OtherView right{
        {}, stages::mirrored(std::move(mirrored)), {}, pair.views.right, std::move(pair.pictures.right)};
    for (Image* image : {&right.color, &right.picture})
        if (!image->empty()) matching::relight(*image, range.correction.light, threads);
    return right;
}

}  // namespace

DisparityMap map_by_surface(const OtherView& right, const stages::SeenSurface& here, const LeftView& left,
                            int threads) {
    const int width = right.place.width, height = right.place.height;
    DisparityMap map{width, height, std::vector<float>(here.disparities.size())};
    const auto fill_row = [&](int y) {
        const std::size_t row = static_cast<std::size_t>(y) * width;
        const auto is_covered = [&](int x) { return here.disparities[row + x] != stages::kNotCovered; };
        for (int x = 0; x < width; ++x)
            map.values[row + x] =
                is_covered(x) ? static_cast<float>(here.disparities[row + x]) : kUnknownDisparity;
        for (int x = 0; x < width && left.density.background_px > 0; ++x) {
            const float d = left.meshed.at(x, y);
            if (!DisparityMap::known(d) || d >= left.density.background_px) continue;
            const double there = right.place.from_left({x + 0.5, y + 0.5, d}).x;
            if (!(there >= 0 && there < width)) continue;
            float& nearest = map.values[row + static_cast<std::size_t>(there)];
            if (!is_covered(static_cast<int>(there)) && (!DisparityMap::known(nearest) || nearest < d))
                nearest = d;
        }
    };
    stages::for_row_bands(height, threads, [&](int begin, int end) {
        for (int y = begin; y < end; ++y) fill_row(y);
    });
    const int reduced = std::max(kFilled, std::max(width, height) / kFilled_px);
    DisparityMap small{std::max(1, width / reduced), std::max(1, height / reduced), {}};
    for (int y = 0; y < small.height; ++y)
        for (int x = 0; x < small.width; ++x)
            small.values.push_back(
                map.at(std::min(width - 1, reduced * x), std::min(height - 1, reduced * y)));
    if (std::none_of(small.values.begin(), small.values.end(), DisparityMap::known)) return map;
    small = stages::fill_holes(
        small,
        right.color.empty() ? Image{} : exporters::resized(right.color, small.width, small.height, threads),
        threads);
    stages::for_row_bands(height, threads, [&](int begin, int end) {
        for (int y = begin; y < end; ++y)
            for (int x = 0; x < width; ++x) {
                float& d = map.at(x, y);
                if (!DisparityMap::known(d))
                    d = small.at(std::min(small.width - 1, x / reduced),
                                 std::min(small.height - 1, y / reduced));
            }
    });
    return map;
}

OtherView unmatched_right_view(InputPair& pair, const stages::FoundRange& range, int threads) {
    return right_view({}, pair, range, threads);
}

OtherView right_view_of_program(InputPair& pair, const stages::ViewMaps& maps,
                                const stages::FoundRange& range, int threads) {
    const stages::ViewMaps seen_in_mirror{stages::mirrored(maps.right), stages::mirrored(maps.left),
                                          maps.is_dense};
    return right_view(refine_given(stages::mirrored(pair.views), seen_in_mirror, range.config, threads), pair,
                      range, threads);
}

void complete_right_view(OtherView& right, const LeftView& left, const DisparityResult& disparity,
                         const readers::PixelMask& mask, int threads) {
    right.place = {.right = 1,
                   .shift_px = left.pair_camera.doffs_px - left.calibration.doffs_px,
                   .width = left.disparity.width,
                   .height = left.disparity.height};
    right.kept = mask.kept;
    if (right.map.values.empty()) return;
    for (std::size_t i = 0; i < right.map.values.size(); ++i) {
        float& d = right.map.values[i];
        if (DisparityMap::known(d)) d = std::max(d + static_cast<float>(right.place.shift_px), left.least_px);
        if (d <= -left.calibration.doffs_px) d = kUnknownDisparity;
    }
    drop_background(right, left.density.background_px);
    if (const auto& noise = disparity.noise; noise.noise_px > 0)
        right.map = stages::dequantize(right.map, noise.quantum_px, threads);
}

void drop_background(stages::OtherView& right, float background_px) {
    for (std::size_t i = 0; i < right.map.values.size(); ++i)
        if (right.map.values[i] < background_px || (!right.kept.empty() && !right.kept[i]))
            right.map.values[i] = kUnknownDisparity;
}

}  // namespace hexrelief::job
