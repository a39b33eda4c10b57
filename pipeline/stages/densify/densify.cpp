#include "pipeline/stages/densify/densify.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <utility>
#include <vector>

#include "pipeline/base/opencv_squares.h"
#include "pipeline/base/thread_pool.h"
#include "pipeline/data/start_work.h"
#include "pipeline/stages/densify/measurements.h"
#include "pipeline/stages/densify/plane_votes.h"

namespace hexrelief::stages {
namespace {

constexpr int kReach = 3, kMostOffsets = (2 * kReach + 1) * (2 * kReach + 1);
constexpr float kSteepest = 2;     // px of disparity per px
constexpr float kReach_px = 1.5f;  // measurements farther off a plane belong to another surface
// Cost of a plane that fits; largest ratio to a flat plane's cost for a plane that replaces it.
constexpr float kGood = 0.05f, kBetter = 0.45f;
constexpr int kTried = 6;  // measurements whose pairs give planes to try
// Regularisation towards a plane that faces the camera: decides if all measurements lie on one line.
constexpr float kRidge = 0.01f;

struct Slopes {
    float x = 0, y = 0;
};

// A measurement relative to the one whose plane is sought.
struct Offset {
    float x, y, d, weight;

    float off(Slopes s) const { return d - s.x * x - s.y * y; }
};

struct Neighbours {
    Offset offsets[kMostOffsets];
    int count = 0;
    float weight = 0;

    // Returns the plane's cost, as a share of the cost if all neighbours were on other surfaces.
    float cost(Slopes s) const {
        float sum = 0;
        for (int i = 0; i < count; ++i) {
            const float off = offsets[i].off(s) / kReach_px;
            sum += offsets[i].weight * std::min(off * off, 1.0f);
        }
        return weight > 0 ? sum / weight : 0;
    }
    // Returns the least squares plane of the neighbours that lie within twice the reach of the given plane.
    Slopes fitted(Slopes s) const {
        float xx = 0, xy = 0, yy = 0, xd = 0, yd = 0, sum = 0;
        for (int i = 0; i < count; ++i) {
            const Offset& o = offsets[i];
            const float t = o.off(s) / (2 * kReach_px);
            if (!(t * t < 1)) continue;
            const float w = o.weight * (1 - t * t);
            xx += w * o.x * o.x;
            xy += w * o.x * o.y;
            yy += w * o.y * o.y;
            xd += w * o.x * o.d;
            yd += w * o.y * o.d;
            sum += w;
        }
        xx += kRidge * sum;
        yy += kRidge * sum;
        const float determinant = xx * yy - xy * xy;
        if (!(determinant > 0)) return s;
        return {std::clamp((xd * yy - yd * xy) / determinant, -kSteepest, kSteepest),
                std::clamp((yd * xx - xd * xy) / determinant, -kSteepest, kSteepest)};
    }
    // Returns the best of the planes through the measurement and two neighbours, if it is much better than a
    // flat plane; else the flat plane.
    Slopes best_pair(float least_determinant) const {
        Slopes best;
        float least = kBetter * cost(best);
        const int step = std::max(1, count / kTried);
        for (int i = 0; i < count; i += step)
            for (int k = i + step; k < count; k += step) {
                const Offset &a = offsets[i], &b = offsets[k];
                const float determinant = a.x * b.y - a.y * b.x;
                if (std::abs(determinant) < least_determinant) continue;
                const Slopes s{(a.d * b.y - b.d * a.y) / determinant, (b.d * a.x - a.d * b.x) / determinant};
                if (std::abs(s.x) > kSteepest || std::abs(s.y) > kSteepest) continue;
                const float c = cost(s);
                if (c < least) {
                    least = c;
                    best = s;
                }
            }
        return best;
    }
};

Neighbours neighbours_of(std::uint32_t own, const std::vector<PlaneAt>& planes,
                         const NearestMeasurements& nearest, int stride_px) {
    Neighbours found;
    const PlaneAt& at = planes[own];
    std::uint32_t last = own;
    for (int j = -kReach; j <= kReach; ++j)
        for (int i = -kReach; i <= kReach; ++i) {
            const std::uint32_t k = nearest.of(at.x + i * stride_px, at.y + j * stride_px);
            if (k == kNoMeasurement || k == own || k == last) continue;
            last = k;
            const float weight = 1 / static_cast<float>(1 + i * i + j * j);
            found.offsets[found.count++] = {static_cast<float>(planes[k].x - at.x),
                                            static_cast<float>(planes[k].y - at.y), planes[k].d - at.d,
                                            weight};
            found.weight += weight;
        }
    return found;
}

Slopes slopes_of(const Neighbours& neighbours, int stride_px) {
    Slopes s = neighbours.fitted(neighbours.fitted({}));
    if (neighbours.cost(s) <= kGood) return s;
    s = neighbours.best_pair(static_cast<float>(stride_px));
    return neighbours.fitted(neighbours.fitted(s));
}

// Sets the slopes of each plane to those that most measurements around it agree on. These are the
// measurements nearest to the pixels of a window of 7x7 at strides of stride_px. Those on other
// surfaces do not count.
void fit_planes(std::vector<PlaneAt>& planes, const NearestMeasurements& nearest, int stride_px,
                ThreadPool& pool) {
    // Only positions and disparities are read and only slopes are written, so the order of
    // measurements does not matter.
    pool.parallel_for_chunks(planes.size(), [&](std::size_t m) {
        const Slopes s =
            slopes_of(neighbours_of(static_cast<std::uint32_t>(m), planes, nearest, stride_px), stride_px);
        planes[m].slope_x = s.x;
        planes[m].slope_y = s.y;
    });
}

constexpr int kHoleStride_px = 4;  // slopes are taken from up to three of these around a pixel
constexpr int kRim_px = 4 * kHoleStride_px;

// Returns the map's pixels that are near unknown ones; all others are unknown as well.
DisparityMap rims_of_holes(const DisparityMap& map) {
    std::vector<std::uint8_t> near(map.values.size());
    for (std::size_t i = 0; i < near.size(); ++i) near[i] = !DisparityMap::known(map.values[i]);
    take_largest(near, map.width, map.height, kRim_px);
    DisparityMap rims = map;
    for (std::size_t i = 0; i < near.size(); ++i)
        if (!near[i]) rims.values[i] = kUnknownDisparity;
    return rims;
}

constexpr std::array kReaches_px{3, 5, 8};  // from a pixel to both ends of the step
constexpr float kLeastStep_px = 3;
constexpr float kSteeper = 2.5F;       // than both ends
constexpr float kMostSlope = 0.35F;    // of the step, in a px: a sharp one has 0.5 on both sides
constexpr float kLeastSlope = 0.04F;   // of the step, over the reach: it rises all the way
constexpr float kEnd = 0.08F;          // of the step: what is nearer to an end lies on that surface
constexpr double kMoreThanSharp = 40;  // times; a true map has at most 0.7, a blurred one more than 100
constexpr float kOwnSide = 0.42F;  // of the step, from an end: what the blur has not brought to its middle
constexpr std::ptrdiff_t kOneSided = 6;  // bleeding has one side more by 1 of 4 pixels, a blur by 1 of 8
constexpr double kLeastBlurred = 0.001, kMostBlurred = 0.25;  // of the map

// A row or a column of the map.
struct Line {
    const float* first;
    std::ptrdiff_t stride;
    int length;
    float operator[](int i) const { return first[i * stride]; }
};

bool is_on_blurred_step(const Line& line, int i, int reach) {
    const float low = line[i - reach], high = line[i + reach], step = high - low, size = std::abs(step);
    if (!(size >= kLeastStep_px) || !DisparityMap::known(step)) return false;
    const float sign = step > 0 ? 1.0F : -1.0F;
    const float before = sign * (line[i] - line[i - 1]), after = sign * (line[i + 1] - line[i]);
    const float slope = (before + after) / 2, least = kLeastSlope * size / static_cast<float>(reach);
    const float first_end = std::abs(line[i - reach + 1] - line[i - reach - 1]) / 2;
    const float last_end = std::abs(line[i + reach + 1] - line[i + reach - 1]) / 2;
    const float part = (line[i] - low) / step;
    return before > least && after > least && slope <= kMostSlope * size &&
           slope >= kSteeper * std::max(first_end, last_end) && part > kEnd && part < 1 - kEnd;
}

// True if most of what the map rises around two neighbours, it rises between them.
bool is_sharp_step(const Line& line, int i) {
    const float step = std::abs(line[i + 1] - line[i]);
    const float around = std::abs(line[std::min(i + 4, line.length - 1)] - line[std::max(i - 3, 0)]);
    return DisparityMap::known(step) && step >= kLeastStep_px && !(around > 2 * step);
}

bool is_on_other_side(float d, const std::array<float, 2>& ends) {
    return std::abs(d - ends[0]) > std::abs(d - ends[1]);
}

struct Steps {
    std::vector<std::uint8_t> blurred;  // 1 for each pixel on a blurred step
    std::vector<std::array<float, 2>>
        ends;               // of the largest one there, first that nearer to the pixel's value
    std::size_t sharp = 0;  // pairs of neighbours with a sharp one between them
};

Steps find_steps(const DisparityMap& map) {
    Steps steps{std::vector<std::uint8_t>(map.values.size(), 0),
                std::vector<std::array<float, 2>>(map.values.size(), {0, 0}), 0};
    const auto search = [&](std::size_t start, std::ptrdiff_t stride, int length) {
        const Line line{map.values.data() + start, stride, length};
        for (int i = 0; i + 1 < length; ++i) steps.sharp += is_sharp_step(line, i);
        for (const int reach : kReaches_px)
            for (int i = reach + 1; i < length - reach - 1; ++i)
                if (is_on_blurred_step(line, i, reach)) {
                    const auto pixel = start + static_cast<std::size_t>(i * stride);
                    std::array ends{line[i - reach], line[i + reach]};
                    if (is_on_other_side(line[i], ends)) std::swap(ends[0], ends[1]);
                    auto& largest = steps.ends[pixel];
                    if (std::abs(ends[1] - ends[0]) > std::abs(largest[1] - largest[0])) largest = ends;
                    steps.blurred[pixel] = 1;
                }
    };
    for (int y = 0; y < map.height; ++y) search(static_cast<std::size_t>(y) * map.width, 1, map.width);
    for (int x = 0; x < map.width; ++x) search(static_cast<std::size_t>(x), map.width, map.height);
    return steps;
}

// Puts pixels back to the side of the step that they had in the blurred map, except those in its middle. The
// colours decide alone if they move pixels to one side of the step, as where a thing bleeds over its edge; if
// they move as many to the other side, that is their own error.
void keep_sides(DisparityMap& filled, const DisparityMap& blurred, const Steps& steps) {
    std::ptrdiff_t same = 0, to_one_side = 0;
    for (std::size_t i = 0; i < filled.values.size(); ++i) {
        if (!steps.blurred[i]) continue;
        if (const auto& ends = steps.ends[i]; !is_on_other_side(filled.values[i], ends))
            ++same;
        else
            to_one_side += ends[0] < ends[1] ? 1 : -1;
    }
    if (kOneSided * std::abs(to_one_side) >= same) return;
    for (std::size_t i = 0; i < filled.values.size(); ++i) {
        const auto& ends = steps.ends[i];
        if (steps.blurred[i] && is_on_other_side(filled.values[i], ends) &&
            std::abs(blurred.values[i] - ends[0]) < kOwnSide * std::abs(ends[1] - ends[0]))
            filled.values[i] = ends[0];
    }
}

}  // namespace

DisparityMap densify(const DisparityMap& sparse, const Image& left, int threads) {
    ThreadPool pool(threads);
    std::vector<PlaneAt> planes = measurements_of(sparse);
    const NearestMeasurements around = find_nearest(planes, sparse.width, sparse.height, {});
    const int typical_px = typical_distance_px(sparse, around);
    const std::vector<std::uint8_t> filled = pixels_to_fill(sparse, around, typical_px);
    const NearestMeasurements nearest =
        left.empty() ? around : find_nearest(planes, sparse.width, sparse.height, left);
    const int stride_px = std::max(1, (4 * typical_px + 2) / 5);
    fit_planes(planes, nearest, stride_px, pool);
    const SideInput sides{planes, around, smoothed(left, pool), stride_px};
    return take_votes({sparse, planes, nearest, filled, left, sides}, stride_px, pool);
}

DisparityMap fill_holes(const DisparityMap& map, const Image& left, int threads) {
    ThreadPool pool(threads);
    std::vector<PlaneAt> planes = measurements_of(rims_of_holes(map));
    auto by_colours = start_work(left.empty() ? 1 : threads,
                                 [&] { return find_nearest(planes, map.width, map.height, left); });
    const NearestMeasurements around = find_nearest(planes, map.width, map.height, {});
    const NearestMeasurements nearest = left.empty() ? around : by_colours.get();
    fit_planes(planes, around, kHoleStride_px, pool);
    const std::vector<std::uint8_t> all(map.values.size(), 1);
    const SideInput sides{planes, around, smoothed(left, pool), kHoleStride_px};
    return take_votes({map, planes, nearest, all, left, sides}, kHoleStride_px, pool);
}

SharpenedMap sharpen_steps(DisparityMap map, const Image& left, int threads) {
    const Steps steps = find_steps(map);
    const auto all = static_cast<double>(map.values.size());
    const auto found = static_cast<double>(std::ranges::count(steps.blurred, std::uint8_t{1}));
    if (found <= kMoreThanSharp * static_cast<double>(steps.sharp) || found < kLeastBlurred * all)
        return {std::move(map), 0};
    std::vector<std::uint8_t> blurred = steps.blurred;
    take_largest(blurred, map.width, map.height, 1);
    const double share = static_cast<double>(std::ranges::count(blurred, std::uint8_t{1})) / all;
    if (share > kMostBlurred) return {std::move(map), 0};
    DisparityMap open{map.width, map.height, map.values, {}};
    for (std::size_t i = 0; i < blurred.size(); ++i)
        if (blurred[i]) open.values[i] = kUnknownDisparity;
    DisparityMap filled = fill_holes(open, left, threads);
    keep_sides(filled, map, steps);
    for (std::size_t i = 0; i < blurred.size(); ++i)
        if (blurred[i] && DisparityMap::known(map.values[i])) map.values[i] = filled.values[i];
    return {std::move(map), share};
}

}  // namespace hexrelief::stages
