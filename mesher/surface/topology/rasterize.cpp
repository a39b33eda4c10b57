#include "mesher/surface/topology/rasterize.h"

#include <algorithm>

#include "pipeline/base/simd.h"

namespace hexrelief::surface {
namespace {

constexpr int kRows = 8;  // rows found at a time
// px: if a side runs nearer than this to a pixel's centre, rounding might decide on which side the centre
// lies, and the exact test is needed. Far above the rounding error.
constexpr double kDoubtful_px = 1e-6;
constexpr double kLevel_px = 1e-9;  // px: a side of less height may cross a row's centre line anywhere

// A side of a triangle, and the rows between its ends; in all other rows the other two
// sides bound the triangle.
struct Side {
    EdgeLine line;
    RowRange rows;
};

Side side_between(const Vec2f& a, const Vec2f& b, int height) {
    return {EdgeLine(a, b), centres_between(std::min(a.y, b.y), std::max(a.y, b.y), height)};
}

// Finds the runs of rows y .. y + kRows - 1 within the columns of `whole`. Returns false if
// rounding might decide about one. Its loops have a constant length, no branches and numbers of one
// size, so that they vectorise.
HEXRELIEF_VECTORS bool find_rows(const Side* sides, const PixelRun& whole, int y, PixelRun* __restrict runs) {
    const double lowest = whole.first - 1, highest = whole.end + 1;
    // The first pixels of the rows, and the negated ends of the rows: sides only raise either.
    double limits[2][kRows];
    double closest[kRows];  // px: least distance of a side from a pixel's centre
    for (int i = 0; i < kRows; ++i) limits[0][i] = whole.first, limits[1][i] = -whole.end, closest[i] = 1;
    bool is_level = false;
    for (int k = 0; k < 3; ++k) {
        const EdgeLine line = sides[k].line;
        const double first = sides[k].rows.first, end = sides[k].rows.end;
        const double sign = line.is_first() ? 1 : -1;
        is_level |= (line.height() < kLevel_px) & (first < y + kRows) & (end > y);
        double* const limit = limits[line.is_first() ? 0 : 1];
#pragma GCC unroll 1  // if unrolled, it would not vectorise
        for (int i = 0; i < kRows; ++i) {
            const double centre = y + i + 0.5, exact = line.place(y + i);
            const double above = exact < lowest ? lowest : exact, place = above > highest ? highest : above;
            const double at = static_cast<int>(place), part = place - at;
            const double distance = part < 0.5 ? part : 1 - part;
            const bool own = (centre > first) & (centre < end);
            const double own_limit = own ? sign * at : limit[i], own_distance = own ? distance : 1.0;
            limit[i] = limit[i] > own_limit ? limit[i] : own_limit;
            closest[i] = closest[i] < own_distance ? closest[i] : own_distance;
        }
    }
    int firsts[kRows], ends[kRows];
#pragma GCC unroll 1
    for (int i = 0; i < kRows; ++i) {
        const double first = limits[0][i] < whole.end ? limits[0][i] : whole.end;
        firsts[i] = static_cast<int>(first);
        ends[i] = static_cast<int>(-limits[1][i] > first ? -limits[1][i] : first);
    }
    bool is_doubtful = is_level;
    for (int i = 0; i < kRows; ++i) {
        runs[i] = {y + i, firsts[i], ends[i]};
        is_doubtful |= closest[i] < kDoubtful_px;
    }
    return !is_doubtful;
}

}  // namespace

std::span<const PixelRun> find_runs(int width, int height, const Vec2f& a, const Vec2f& b, const Vec2f& c,
                                    std::vector<PixelRun>& buffer) {
    const RowRange columns = triangle_columns(width, a, b, c), rows = triangle_rows(height, a, b, c);
    if (rows.first >= rows.end) return {};
    const std::size_t count = static_cast<std::size_t>(rows.end - rows.first);
    if (buffer.size() < count + kRows) buffer.resize(2 * (count + kRows));
    const PixelRun whole{0, columns.first, std::max(columns.first, columns.end)};
    const Side sides[3] = {side_between(a, b, height), side_between(b, c, height),
                           side_between(c, a, height)};
    for (int y = rows.first; y < rows.end; y += kRows) {
        PixelRun* const runs = buffer.data() + (y - rows.first);
        if (find_rows(sides, whole, y, runs)) continue;
        const TriangleRows exact(width, height, a, b, c);
        for (int i = 0; i < kRows; ++i) runs[i] = exact.run(y + i);
    }
    return {buffer.data(), count};
}

}  // namespace hexrelief::surface
