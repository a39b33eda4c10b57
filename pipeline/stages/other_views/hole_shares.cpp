#include "pipeline/stages/other_views/hole_shares.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <vector>

#include "pipeline/data/start_work.h"
#include "pipeline/stages/surface_raster.h"

namespace hexrelief::stages {
namespace {

constexpr int kSamples = 3;        // along each side of a pixel
constexpr int kBand = 512;         // rows that are rasterised at once
constexpr int kMedianLines = 9;    // of the field's ends: maps err at the picture's border
constexpr double kNearest = 0.95;  // percentile of the disparities that stay in place seen from above

// Returns the map with each unknown pixel as far as the farther known one beside it in its row. Rows without
// any are as the row before them.
std::vector<float> without_holes(const DisparityMap& map) {
    std::vector<float> values = map.values;
    const auto width = static_cast<std::size_t>(map.width);
    for (std::size_t row = 0; row < values.size(); row += width) {
        float before = kUnknownDisparity;
        for (std::size_t i = row; i < row + width; ++i) {
            if (DisparityMap::known(map.values[i])) before = map.values[i];
            values[i] = before;
        }
        float after = kUnknownDisparity;
        for (std::size_t i = row + width; i-- > row;) {
            if (DisparityMap::known(map.values[i])) after = map.values[i];
            values[i] = std::min(values[i], after);
        }
        if (row > 0 && !DisparityMap::known(values[row]))
            std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(row - width), width,
                        values.begin() + static_cast<std::ptrdiff_t>(row));
    }
    return values;
}

// Where the field begins and ends in each line of a view.
struct Field {
    std::vector<double> begins, ends;
    bool holds(std::size_t line, double at) const { return at >= begins[line] && at <= ends[line]; }
};

std::vector<double> smoothed(const std::vector<double>& ends) {
    std::vector<double> result(ends.size()), around(kMedianLines);
    const int count = static_cast<int>(ends.size());
    for (int i = 0; i < count; ++i) {
        for (int k = 0; k < kMedianLines; ++k)
            around[k] = ends[std::clamp(i + k - kMedianLines / 2, 0, count - 1)];
        std::nth_element(around.begin(), around.begin() + kMedianLines / 2, around.end());
        result[i] = around[kMedianLines / 2];
    }
    return result;
}

// Returns the field in lines of `count` pixels. place(line, i): where the i-th pixel of a line lies in the
// view.
template <class Place>
Field field_of(int lines, int count, const Place& place) {
    Field field{std::vector<double>(lines), std::vector<double>(lines)};
    for (int line = 0; line < lines; ++line) {
        double low = place(line, 0), high = low;
        for (int i = 1; i < count; ++i) {
            low = std::min(low, place(line, i));
            high = std::max(high, place(line, i));
        }
        field.begins[line] = low - 0.5;
        field.ends[line] = high + 0.5;
    }
    return {smoothed(field.begins), smoothed(field.ends)};
}

// Returns the share of the pixels in the field that triangles cover by less than a half. is_inside(x, y): of
// a pixel.
template <class IsInside>
double open_share(const std::vector<ViewPoint>& points, const SurfaceMesh& mesh, const DisparityMap& map,
                  const IsInside& is_inside, int threads) {
    std::atomic<long long> all_inside{0}, all_open{0};
    for (int top = 0; top < map.height; top += kBand) {
        const int rows = std::min(kBand, map.height - top);
        View band{points, &mesh.triangles, map.width * kSamples, rows * kSamples};
        for (ViewPoint& p : band.points) {
            p.x *= kSamples;
            p.y = (p.y - top) * kSamples;
        }
        const std::vector<char> is_covered = rasterise_coverage(band, threads);
        for_row_bands(rows, threads, [&](int begin, int end) {
            long long inside = 0, open = 0;
            for (int y = begin; y < end; ++y)
                for (int x = 0; x < map.width; ++x) {
                    if (!is_inside(x, top + y)) continue;
                    int covered = 0;
                    for (int v = y * kSamples; v < (y + 1) * kSamples; ++v)
                        for (int u = x * kSamples; u < (x + 1) * kSamples; ++u)
                            covered += is_covered[static_cast<std::size_t>(v) * band.width + u];
                    ++inside;
                    open += 2 * covered < kSamples * kSamples;
                }
            all_inside += inside;
            all_open += open;
        });
    }
    return all_inside == 0 ? 0 : static_cast<double>(all_open) / static_cast<double>(all_inside);
}

}  // namespace

HoleShares measure_holes(const SurfaceMesh& mesh, const DisparityMap& map, double shift_px, int threads) {
    const std::vector<float> field_map = without_holes(map);
    std::vector<float> known;
    std::ranges::copy_if(field_map, std::back_inserter(known), DisparityMap::known);
    if (known.size() < field_map.size()) return {};
    const double rank = kNearest * static_cast<double>(known.size() - 1);
    const double nearest_px = std::rint(value_at_rank(known, static_cast<std::size_t>(rank)));
    const auto at = [&](int x, int y) {
        return static_cast<double>(field_map[static_cast<std::size_t>(y) * map.width + x]);
    };
    std::vector<ViewPoint> right, above;
    for (std::size_t i = 0; i < mesh.image_points.size(); ++i) {
        const double x = mesh.image_points[i].x, y = mesh.image_points[i].y, d = mesh.disparities[i];
        right.push_back({x - (d - shift_px), y, d});
        above.push_back({x, y + d - nearest_px, d});
    }
    auto at_right = start_work(threads, [&] {
        const Field rows =
            field_of(map.height, map.width, [&](int y, int x) { return x + 0.5 - (at(x, y) - shift_px); });
        return open_share(
            right, mesh, map, [&](int x, int y) { return rows.holds(y, x + 0.5); }, threads);
    });
    const Field columns =
        field_of(map.width, map.height, [&](int x, int y) { return y + 0.5 + at(x, y) - nearest_px; });
    const double above_share = open_share(
        above, mesh, map, [&](int x, int y) { return columns.holds(x, y + 0.5); }, threads);
    return {at_right.get(), above_share};
}

}  // namespace hexrelief::stages
