// Finds the pixels in a triangle: those whose centres lie in it, one run per row.
#pragma once

#include "pipeline/base/host_device.h"
#include "pipeline/data/geometry.h"

namespace hexrelief::surface {

struct PixelRun {
    int y = 0, first = 0, end = 0;  // pixels first .. end - 1 of row y
    friend HEXRELIEF_HD bool operator==(const PixelRun& a, const PixelRun& b) {
        return a.y == b.y && a.first == b.first && a.end == b.end;
    }
};

// True if pixels of two runs are neighbours, also diagonally; `lower` is in the next row.
HEXRELIEF_HD bool touch(const PixelRun& upper, const PixelRun& lower) {
    return upper.y + 1 == lower.y && upper.first <= lower.end && lower.first <= upper.end;
}

struct RowRange {
    int first = 0, end = 0;
};

// Returns the pixels, within 0 .. size - 1, whose centres lie from lo to hi; first >= end if there are none.
HEXRELIEF_HD RowRange centres_between(float lo, float hi, int size) {
    // rounded up and down without the library's calls
    const float least = lo - 0.5f, most = hi - 0.5f;
    const int up = static_cast<int>(least), down = static_cast<int>(most);
    return {step::max_of(0, up + (static_cast<float>(up) < least)),
            step::min_of(size, down - (static_cast<float>(down) > most) + 1)};
}

// One side of a triangle. A pixel centre on a shared side belongs to exactly one of its two triangles,
// because both compute the same number except for its sign.
class EdgeLine {
  public:
    HEXRELIEF_HD EdgeLine(Vec2f a, Vec2f b) : turned_(b.y < a.y || (b.y == a.y && b.x < a.x)) {
        if (turned_) {
            const Vec2f first = b;
            b = a;
            a = first;
        }
        x_ = a.x;
        y_ = a.y;
        dx_ = double(b.x) - a.x;
        dy_ = double(b.y) - a.y;
        slope_ = dx_ / step::max_of(dy_, 1e-30);
    }
    // Abscissa of the line at the centres of row y, plus 0.5: except for rounding, its integer part is the
    // first pixel of the row that is not left of the line.
    HEXRELIEF_HD double place(int y) const { return x_ + slope_ * (y + 0.5 - y_) + 0.5; }
    HEXRELIEF_HD double height() const { return dy_; }
    // Returns the first of a row's pixels first .. end - 1 that is not left of the line, or `end`.
    HEXRELIEF_HD int crossing(int y, int first, int end) const {
        const double down = y + 0.5 - y_, across = dx_ * down;
        const auto is_left = [&](int x) { return across - dy_ * (x + 0.5 - x_) >= 0; };
        // the exact test follows
        int at = static_cast<int>(step::clamp_to<double>(place(y), first, end));
        bool back = (at > first) & !is_left(at - 1), on = (at < end) & is_left(at);
        while (back) back = --at > first && !is_left(at - 1);
        while (on) on = ++at < end && is_left(at);
        return at;
    }
    // True if the triangle lies to the right of the line.
    HEXRELIEF_HD bool is_first() const { return turned_; }

  private:
    double x_, y_, dx_, dy_, slope_;
    bool turned_;
};

// Returns the rows with pixel centres between a triangle's highest and lowest corner.
HEXRELIEF_HD RowRange triangle_rows(int height, const Vec2f& a, const Vec2f& b, const Vec2f& c) {
    return centres_between(step::min_of(a.y, step::min_of(b.y, c.y)),
                           step::max_of(a.y, step::max_of(b.y, c.y)), height);
}

// Returns the columns with pixel centres between a triangle's leftmost and rightmost corner.
HEXRELIEF_HD RowRange triangle_columns(int width, const Vec2f& a, const Vec2f& b, const Vec2f& c) {
    return centres_between(step::min_of(a.x, step::min_of(b.x, c.x)),
                           step::max_of(a.x, step::max_of(b.x, c.x)), width);
}

// The runs of a triangle's pixels, which may be asked for in any order of rows.
class TriangleRows {
  public:
    HEXRELIEF_HD TriangleRows(int width, int height, const Vec2f& a, const Vec2f& b, const Vec2f& c)
        : columns_(triangle_columns(width, a, b, c)),
          rows_(triangle_rows(height, a, b, c)),
          ab_(a, b),
          bc_(b, c),
          ca_(c, a) {}
    HEXRELIEF_HD int first() const { return rows_.first; }
    HEXRELIEF_HD int end() const { return step::max_of(rows_.first, rows_.end); }
    HEXRELIEF_HD PixelRun run(int y) const {
        const int first = columns_.first, end = step::max_of(first, columns_.end);
        PixelRun run{y, first, end};
        const auto clip = [&](const EdgeLine& side, int at) {
            run.first = side.is_first() ? step::max_of(run.first, at) : run.first;
            run.end = side.is_first() ? run.end : step::min_of(run.end, at);
        };
        // each side is searched on its own, so that the three searches overlap and take as long as one
        const int ab = ab_.crossing(y, first, end), bc = bc_.crossing(y, first, end),
                  ca = ca_.crossing(y, first, end);
        clip(ab_, ab);
        clip(bc_, bc);
        clip(ca_, ca);
        run.end = step::max_of(run.first, run.end);
        return run;
    }

  private:
    RowRange columns_, rows_;
    EdgeLine ab_, bc_, ca_;
};

// Calls visit(run) for each row of the triangle, including empty runs.
template <typename Visit>
HEXRELIEF_HD void each_run(int width, int height, const Vec2f& a, const Vec2f& b, const Vec2f& c,
                           const Visit& visit) {
    const TriangleRows rows(width, height, a, b, c);
    for (int y = rows.first(); y < rows.end(); ++y) visit(rows.run(y));
}

}  // namespace hexrelief::surface
