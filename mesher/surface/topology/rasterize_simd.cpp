#include "mesher/surface/topology/rasterize_simd.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "mesher/common/simd.h"

namespace hexrelief {
namespace {

constexpr int K = 8;  // rows
constexpr double kLevel_px = 1e-12;
// A line's place in a row as whole pixels and so many parts of one: nearer to a pixel's centre than one part
// rounding might decide. More than rounding can be.
constexpr double kParts = 1 << 19;

typedef double Places __attribute__((vector_size(8 * K)));
typedef std::int32_t Rows __attribute__((vector_size(4 * K)));

struct Line {
    TriangleLabel side;
    RowRange rows;  // that it reaches: beyond, the triangle's other sides are nearer
};

Line line_between(const Vec2f& a, const Vec2f& b, int height) {
    return {TriangleLabel(a, b), centres_between(std::min(a.y, b.y), std::max(a.y, b.y), height)};
}

void clip_exactly(const Line* lines, PixelRun& run) {
    for (int k = 0; k < 3; ++k) {
        if (run.y < lines[k].rows.first || run.y >= lines[k].rows.end) continue;
        const int at = lines[k].side.crossing(run.y, run.first, run.end);
        (lines[k].side.is_first() ? run.first : run.end) = at;
    }
}

// Rows y .. y + 7 of a triangle within the columns of `whole`.
HEXRELIEF_VECTORS void find_rows(const Line* lines, const PixelRun& whole, int y, PixelRun* __restrict runs) {
    const Rows numbers = Rows{0, 1, 2, 3, 4, 5, 6, 7} + y;
    const Places centres = __builtin_convertvector(numbers, Places) + 0.5,
                 low = Places{} + (whole.first - 1.0), high = Places{} + (whole.end + 1.0);
    Rows first = Rows{} + whole.first, end = Rows{} + whole.end, unsure{};
    for (int k = 0; k < 3; ++k) {
        const Line& line = lines[k];
        Places place;
        line.side.place_at(centres, place);
        const Places above = place < low ? low : place, inside = above > high ? high : above;
        const Rows at = __builtin_convertvector(inside, Rows);
        const Rows part =
            __builtin_convertvector((inside - __builtin_convertvector(at, Places)) * kParts, Rows);
        const Rows own = (numbers >= line.rows.first) & (numbers < line.rows.end);
        const Rows level = Rows{} - (line.side.height() < kLevel_px);
        unsure |= own & ((part < 1) | (part > static_cast<int>(kParts) - 2) | level);
        const Rows clipped = own & (line.side.is_first() ? at > first : at < end);
        Rows& clip = line.side.is_first() ? first : end;
        clip = clipped ? at : clip;
    }
    first = first > whole.end ? Rows{} + whole.end : first;
    end = end < first ? first : end;
    std::uint64_t doubts[K / 2];
    std::memcpy(doubts, &unsure, sizeof doubts);
    for (int i = 0; i < K; ++i) runs[i] = {y + i, first[i], end[i]};
    if ((doubts[0] | doubts[1] | doubts[2] | doubts[3]) == 0) return;
    for (int i = 0; i < K; ++i) {
        runs[i] = {y + i, whole.first, whole.end};
        clip_exactly(lines, runs[i]);
    }
}

}  // namespace

std::span<const PixelRun> find_runs(int width, int height, const Vec2f& a, const Vec2f& b, const Vec2f& c,
                                    std::vector<PixelRun>& room) {
    const RowRange columns = triangle_columns(width, a, b, c), rows = triangle_rows(height, a, b, c);
    if (rows.first >= rows.end) return {};
    const std::size_t count = static_cast<std::size_t>(rows.end - rows.first);
    if (room.size() < count + K) room.resize(2 * (count + K));
    const PixelRun whole{0, columns.first, std::max(columns.first, columns.end)};
    const Line lines[3] = {line_between(a, b, height), line_between(b, c, height),
                           line_between(c, a, height)};
    for (std::size_t r = 0; r < count; r += K)
        find_rows(lines, whole, rows.first + static_cast<int>(r), room.data() + r);
    return {room.data(), count};
}

}  // namespace hexrelief
