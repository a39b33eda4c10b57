#include "pipeline/job/relief.h"

#include <algorithm>
#include <cmath>

#include "pipeline/checks/pair_statistics.h"
#include "pipeline/job/pairs/align_pair.h"
#include "pipeline/stages/surface.h"

namespace hexrelief::job {
namespace {

// Counts the unknown pixels of a row that the right camera cannot see. In a run of unknown pixels with
// disparities l on its left and r > l on its right, the last r - l pixels are hidden behind the surface on
// the right. At the image's left edge the right camera's picture begins r px further right.
std::size_t occluded_in_row(const DisparityMap& map, int y) {
    std::size_t occluded = 0;
    float before = 0;  // the last known disparity; 0 = none yet
    int unknown = 0;   // length of the run that ends here
    for (int x = 0; x < map.width; ++x) {
        const float d = map.at(x, y);
        if (!DisparityMap::known(d)) {
            ++unknown;
            continue;
        }
        if (unknown > 0 && d > before) {
            const double hidden = std::floor(static_cast<double>(d) - before);
            occluded +=
                hidden < unknown ? static_cast<std::size_t>(hidden) : static_cast<std::size_t>(unknown);
        }
        before = d;
        unknown = 0;
    }
    return occluded;
}

double area_px(const SurfaceMesh& surface, std::size_t triangles) {
    double doubled = 0;
    for (std::size_t i = 0; i < triangles; ++i) {
        const Triangle& t = surface.triangles[i];
        const Vec2f a = surface.image_points[t[0]], b = surface.image_points[t[1]],
                    c = surface.image_points[t[2]];
        doubled += std::abs((static_cast<double>(b.x) - a.x) * (static_cast<double>(c.y) - a.y) -
                            (static_cast<double>(c.x) - a.x) * (static_cast<double>(b.y) - a.y));
    }
    return doubled / 2;
}

}  // namespace

LeftView Relief::view() const {
    return {disparity.map,
            disparity.meshed(),
            density,
            input.color(),
            input.texture(),
            input.calibration,
            pair_camera,
            disparity.backdrop ? disparity.backdrop->disparity_px : 0,
            right ? &*right : nullptr,
            input.is_whole(),
            input.texture_file.empty() ? nullptr : &input.texture_file,
            input.is_aligned() ? up_if_turned(*input.pair()->alignment) : LeftView::kUpright,
            input.pair() && input.pair()->is_of_points(),
            disparity.has_filled_holes,
            disparity.quantum_px,
            disparity.matched.has_value(),
            input.pair() && input.pair()->is_masked};
}

double Relief::depth_of_backdrop() const {
    if (!disparity.backdrop) return 0;
    const Calibration& camera = input.calibration;
    return -stages::position_in_space(0, 0, disparity.backdrop->disparity_px, camera)[2];
}

std::string Relief::support() const {
    return disparity.matched ? checks::support_word(disparity.support) : "";
}

PictureShares share_picture(const DisparityMap& map, float background_px, const SurfaceMesh& surface,
                            std::size_t triangles, std::size_t blank) {
    std::size_t foreground = 0, known = 0, occluded = 0;
    for (const float d : map.values) {
        known += DisparityMap::known(d);
        foreground += DisparityMap::known(d) && d > 0 && d >= background_px;
    }
    if (known < map.values.size())
        for (int y = 0; y < map.height; ++y) occluded += occluded_in_row(map, y);
    const std::size_t shown = std::max<std::size_t>(1, map.values.size() - blank);
    const auto pixels = static_cast<double>(shown);
    PictureShares shares{.meshed = std::min(1.0, area_px(surface, triangles) / pixels),
                         .foreground = static_cast<double>(foreground) / pixels,
                         .background = static_cast<double>(known - foreground) / pixels};
    occluded = std::min(occluded, shown - std::min(known, shown));
    shares.occluded = static_cast<double>(occluded) / pixels;
    shares.unknown = static_cast<double>(shown - std::min(known + occluded, shown)) / pixels;
    return shares;
}

}  // namespace hexrelief::job
