#include "mesher/triangle_runs.h"

#include <algorithm>

namespace hexrelief {
namespace {

constexpr double kNear_px = 1e-6, kLevel_px = 1e-12;  // more than rounding can be

// A line clips only the rows that its side reaches: beyond, the other two are nearer.
template <bool kLeft>
void clip_rows(const TriangleSide& side, const RowRange& rows, double low, double high, PixelRun* by_row) {
    const bool level = side.height() < kLevel_px;
    for (int y = rows.first; y < rows.end; ++y) {
        PixelRun& run = by_row[y];
        const double place = std::min(std::max(side.place(y), low), high);
        int at = static_cast<int>(place);
        const double off = place - at;
        if (!(off > kNear_px && off < 1 - kNear_px) || level) at = side.crossing(y, run.first, run.end);
        if (kLeft)
            run.first = std::min(std::max(run.first, at), run.end);
        else
            run.end = std::max(std::min(run.end, at), run.first);
    }
}

}  // namespace

void add_runs(int width, int height, const Vec2f& a, const Vec2f& b, const Vec2f& c,
              std::vector<PixelRun>& runs) {
    const RowRange columns = triangle_columns(width, a, b, c), rows = triangle_rows(height, a, b, c);
    if (rows.first >= rows.end) return;
    const PixelRun whole{0, columns.first, std::max(columns.first, columns.end)};
    const std::size_t start = runs.size();
    runs.resize(start + static_cast<std::size_t>(rows.end - rows.first), whole);
    PixelRun* const by_row = runs.data() + start - rows.first;
    for (int y = rows.first; y < rows.end; ++y) by_row[y].y = y;
    const Vec2f corners[4] = {a, b, c, a};
    for (int k = 0; k < 3; ++k) {
        const Vec2f &from = corners[k], &to = corners[k + 1];
        const TriangleSide side(from, to);
        const RowRange own = centres_between(std::min(from.y, to.y), std::max(from.y, to.y), height);
        if (side.is_first())
            clip_rows<true>(side, own, whole.first, whole.end, by_row);
        else
            clip_rows<false>(side, own, whole.first, whole.end, by_row);
    }
}

}  // namespace hexrelief
