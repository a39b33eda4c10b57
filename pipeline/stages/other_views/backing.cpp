#include "pipeline/stages/other_views/backing.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "pipeline/base/opencv_squares.h"
#include "pipeline/base/thread_pool.h"
#include "pipeline/stages/other_views/bridges.h"

namespace hexrelief::stages {
namespace {

constexpr int kSide_px = 320, kReachShare = 10;
constexpr int kOverlap_px = 2;            // that the backing reaches beyond a silhouette
constexpr int kRim_px = 4;                // what is narrower at the border is not met
constexpr double kBehindFarthest_px = 1;  // of the left view
constexpr double kFarShare = 0.3;         // of the depth around, from the farthest on: its colours are taken
constexpr double kOutside = 1e-4;  // weight of colours beyond half the radius: of use if there are no others

struct Grid {
    int width, height;
    std::size_t at(int x, int y) const { return static_cast<std::size_t>(y) * width + x; }
};
using Values = std::vector<double>;

Values largest(Values values, const Grid& grid, int radius) {
    take_largest(values, grid.width, grid.height, radius);
    return values;
}

// Returns the least value that is covered of each square.
Values farthest(Values values, const Grid& grid, int radius) {
    std::ranges::replace(values, kNotCovered, -kNotCovered);
    take_least(values, grid.width, grid.height, radius);
    std::ranges::replace(values, -kNotCovered, kNotCovered);
    return values;
}

// Sums the values of each square.
Values sums(Values values, const Grid& grid, int radius) {
    cv::Mat map(grid.height, grid.width, CV_64F, values.data());
    cv::boxFilter(map, map, -1, {2 * radius + 1, 2 * radius + 1}, {-1, -1}, false, cv::BORDER_CONSTANT);
    return values;
}

// The surface at a reduced size.
struct Reduced {
    Grid grid;
    Values nearest;        // of each square's pixels; kNotCovered = none is covered
    Values is_silhouette;  // 1 for squares with a step between neighbours
    Values is_open;        // 1 for squares with a pixel that is not covered
};

Reduced reduced(const SeenSurface& here, int by, ThreadPool& pool) {
    const int width = here.place.width, height = here.place.height;
    const Grid grid{width / by, height / by};
    const Values zeros(static_cast<std::size_t>(grid.width) * grid.height);
    Reduced small{grid, zeros, zeros, zeros};
    const auto at = [&](int x, int y) { return here.disparities[static_cast<std::size_t>(y) * width + x]; };
    const auto are_apart = [](double a, double b) {
        return a != kNotCovered && b != kNotCovered && std::abs(a - b) > kOneSurface_px;
    };
    pool.parallel_for_each(grid.height, [&](int row) {
        for (int column = 0; column < grid.width; ++column) {
            double nearest = kNotCovered;
            bool is_silhouette = false, is_open = false;
            for (int y = row * by; y < row * by + by; ++y)
                for (int x = column * by; x < column * by + by; ++x) {
                    nearest = std::max(nearest, at(x, y));
                    is_open |= at(x, y) == kNotCovered;
                    is_silhouette |= (x + 1 < width && are_apart(at(x, y), at(x + 1, y))) ||
                                     (y + 1 < height && are_apart(at(x, y), at(x, y + 1)));
                }
            const std::size_t i = grid.at(column, row);
            small.nearest[i] = nearest;
            small.is_silhouette[i] = is_silhouette;
            small.is_open[i] = is_open;
        }
    });
    return small;
}

// Brings a surface forward to the ends of each row and column, as far from there as a camera so many
// baselines beside the view would see it beyond the end; `reach` squares at most.
void meet_ends(Values& surface, const Values& ends, const Grid& grid, int reach, double baselines) {
    const auto meet_end = [&](std::size_t end, std::ptrdiff_t inwards, int count) {
        for (int i = 0; i < std::min(reach, count); ++i) {
            double& d = surface[end + i * inwards];
            const double nearer = ends[end] - d, beyond = std::min<double>(reach, nearer * baselines);
            if (i < beyond) d += nearer * (1 - i / beyond);
        }
    };
    const auto meet_both = [&](std::size_t first, std::ptrdiff_t step, int count) {
        int begin = 0, last = count - 1;
        while (begin < last && ends[first + begin * step] == kNotCovered) ++begin;
        while (begin < last && ends[first + last * step] == kNotCovered) --last;
        meet_end(first + begin * step, step, last - begin);
        meet_end(first + last * step, -step, last - begin);
    };
    for (int y = 0; y < grid.height; ++y) meet_both(grid.at(0, y), 1, grid.width);
    for (int x = 0; x < grid.width; ++x) meet_both(grid.at(x, 0), grid.width, grid.height);
}

}  // namespace

OtherView backing_of(const SeenSurface& here, const Image& picture, double baselines, double least_px,
                     int threads) {
    ThreadPool pool(threads);
    const int longer = std::max(here.place.width, here.place.height);
    const int by = std::min({(longer + kSide_px - 1) / kSide_px, here.place.width, here.place.height}),
              radius = longer / by / kReachShare;
    const Reduced small = reduced(here, by, pool);
    const Grid& grid = small.grid;
    const std::size_t count = small.nearest.size();
    OtherView view;
    view.place = here.place;
    view.place.scale = by;
    view.place.width = grid.width;
    view.place.height = grid.height;
    view.is_backing = true;
    view.map = view.missing = {grid.width, grid.height, std::vector<float>(count, kUnknownDisparity)};

    const Values behind = farthest(small.nearest, grid, radius);
    Values is_covered(count);
    for (std::size_t i = 0; i < count; ++i) is_covered[i] = behind[i] != kNotCovered;
    const auto smoothed = [&](Values values, int squares) {
        for (std::size_t i = 0; i < count; ++i)
            if (is_covered[i] == 0) values[i] = 0;
        const Values numbers = sums(is_covered, grid, squares), totals = sums(values, grid, squares);
        for (std::size_t i = 0; i < count; ++i)
            values[i] = numbers[i] > 0 ? totals[i] / numbers[i] : kNotCovered;
        return values;
    };
    Values surface = smoothed(behind, radius / 2);
    for (double& d : surface)
        if (d != kNotCovered) d = std::max(d - kBehindFarthest_px, least_px);
    meet_ends(surface, farthest(small.nearest, grid, kRim_px), grid, radius, baselines / by);
    surface = smoothed(surface, kRim_px);
    const Values in_front = largest(small.nearest, grid, kOverlap_px),
                 is_near = largest(small.is_silhouette, grid, radius),
                 is_at_end = largest(small.is_open, grid, kOverlap_px);
    for (std::size_t i = 0; i < count; ++i) {
        if (surface[i] == kNotCovered) continue;
        const double d = surface[i];
        view.map.values[i] = static_cast<float>(d / by);
        if (is_near[i] > 0 && is_at_end[i] == 0 && in_front[i] != kNotCovered &&
            in_front[i] - d > kBehindFarthest_px + kOneSurface_px)
            view.missing.values[i] = view.map.values[i];
    }
    if (picture.empty()) return view;

    // Its colours are of what lies in the farther part of its surroundings' depth.
    const Values nearest = largest(small.nearest, grid, radius);
    Values is_far(count);
    for (std::size_t i = 0; i < count; ++i)
        is_far[i] = small.nearest[i] != kNotCovered &&
                    small.nearest[i] - behind[i] <= kFarShare * (nearest[i] - behind[i]);
    // Squares over squares, so that no square's sides show.
    const auto around = [&](const Values& values) {
        Values near = sums(sums(values, grid, radius / 4), grid, radius / 4);
        const Values all = sums(sums(values, grid, radius / 2), grid, radius / 2);
        for (std::size_t i = 0; i < count; ++i) near[i] += kOutside * all[i];
        return near;
    };
    const Values far_count = around(is_far);
    const int channels = picture.channels;
    view.color = {grid.width, grid.height, channels, std::vector<std::uint8_t>(count * channels)};
    for (int c = 0; c < channels; ++c) {
        Values levels(count), far_levels(count);
        pool.parallel_for_each(grid.height, [&](int y) {
            for (int x = 0; x < grid.width; ++x) {
                double sum = 0;
                for (int v = y * by; v < y * by + by; ++v)
                    for (int u = x * by; u < x * by + by; ++u) sum += picture.at(u, v)[c];
                levels[grid.at(x, y)] = sum / (by * by);
                far_levels[grid.at(x, y)] = is_far[grid.at(x, y)] * levels[grid.at(x, y)];
            }
        });
        const Values total = around(far_levels);
        for (std::size_t i = 0; i < count; ++i)
            view.color.pixels[i * channels + c] = static_cast<std::uint8_t>(
                std::lround(far_count[i] > 0 ? total[i] / far_count[i] : levels[i]));
    }
    return view;
}

void join_backing(OtherView& backing, std::size_t least, int reach_px) {
    SeenSurface whole{backing.place, Disparities(backing.map.values.size())};
    std::ranges::transform(backing.map.values, whole.disparities.begin(), [](float d) {
        return DisparityMap::known(d) ? static_cast<double>(d) : kNotCovered;
    });
    const auto by = static_cast<std::size_t>(backing.place.scale);
    paint_bridges(backing, join_regions(backing.missing, whole, least / (by * by), reach_px, kOneSurface_px));
}

}  // namespace hexrelief::stages
