// Step 8: each triangle's pixels, their connected components, and the label that the
// largest component gives it.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "oracle_parts.h"

namespace hexrelief::surface::oracle {
namespace {

// The pixels of a row whose centres lie in a triangle: first .. end - 1.
struct PixelRow {
    int y, first, end;
};

// A pixel centre on an edge belongs to one of the edge's two triangles, because both compute the same number.
bool is_left_of(const Vec2f& upper, const Vec2f& lower, int x, int y) {
    const double dx = double(lower.x) - upper.x, dy = double(lower.y) - upper.y;
    return dx * (y + 0.5 - upper.y) - dy * (x + 0.5 - upper.x) >= 0;
}

bool covers(const std::array<Vec2f, 3>& corners, int x, int y) {
    for (int k = 0; k < 3; ++k) {
        const Vec2f &a = corners[k], &b = corners[(k + 1) % 3];
        const bool rises = b.y < a.y || (b.y == a.y && b.x < a.x);
        if (is_left_of(rises ? b : a, rises ? a : b, x, y) == rises) return false;
    }
    return true;
}

std::vector<PixelRow> rows_of(const Surfaces& s, const std::array<Vec2f, 3>& corners) {
    const auto [left, right] = std::minmax({corners[0].x, corners[1].x, corners[2].x});
    const auto [top, bottom] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
    std::vector<PixelRow> rows;
    for (int y = 0; y < s.height; ++y) {
        if (y + 0.5 < top || y + 0.5 > bottom) continue;
        PixelRow row{y, 0, 0};
        for (int x = 0; x < s.width; ++x) {
            if (x + 0.5 < left || x + 0.5 > right || !covers(corners, x, y)) continue;
            if (row.first == row.end) row.first = x;
            row.end = x + 1;
        }
        if (row.first < row.end) rows.push_back(row);
    }
    return rows;
}

// Finds the connected components of a triangle's pixels.
class Components {
  public:
    Components(const Surfaces& s, const std::vector<PixelRow>& rows) : s_(s) {
        for (const PixelRow& row : rows)
            names_.resize(names_.size() + static_cast<std::size_t>(row.end - row.first));
        std::iota(names_.begin(), names_.end(), std::size_t{0});
        for (std::size_t r = 0; r < rows.size(); ++r) join_neighbours(rows, r);
        for (std::size_t r = 1; r < rows.size(); ++r) bridge(rows, r);
    }
    // Returns, for the i-th pixel, row by row, the number of the first pixel of its component.
    std::size_t name(std::size_t i) const { return names_[i]; }
    // Returns the largest component, the first of equal ones.
    std::size_t largest() const {
        std::vector<std::size_t> areas(names_.size(), 0);
        for (const std::size_t name : names_) ++areas[name];
        return static_cast<std::size_t>(std::max_element(areas.begin(), areas.end()) - areas.begin());
    }

  private:
    std::size_t number(const std::vector<PixelRow>& rows, std::size_t r, int x) const {
        std::size_t before = 0;
        for (std::size_t i = 0; i < r; ++i) before += static_cast<std::size_t>(rows[i].end - rows[i].first);
        return before + static_cast<std::size_t>(x - rows[r].first);
    }
    void join(std::size_t i, std::size_t j) {
        const std::size_t from = std::max(names_[i], names_[j]), to = std::min(names_[i], names_[j]);
        if (from == to) return;
        std::replace(names_.begin(), names_.end(), from, to);
    }
    // Joins neighbours without a discontinuity between them, and pixels that touch at a corner if one of the
    // two ways around it meets none, whichever triangle the third pixel is in.
    void join_neighbours(const std::vector<PixelRow>& rows, std::size_t r) {
        const PixelRow& row = rows[r];
        for (int x = row.first; x + 1 < row.end; ++x)
            if (!s_.has({x, row.y, false})) join(number(rows, r, x), number(rows, r, x + 1));
        if (r + 1 == rows.size() || rows[r + 1].y != row.y + 1) return;
        const PixelRow& below = rows[r + 1];
        for (int x = row.first; x < row.end; ++x)
            for (int u = std::max(x - 1, below.first); u <= std::min(x + 1, below.end - 1); ++u) {
                const int across = std::min(x, u);
                const bool over = u != x && s_.has({across, row.y, false}),
                           under = u != x && s_.has({across, below.y, false});
                const bool side_then_down = !over && !s_.has({u, row.y, true}),
                           down_then_side = !s_.has({x, row.y, true}) && !under;
                if (side_then_down || down_then_side) join(number(rows, r, x), number(rows, r + 1, u));
            }
    }
    // The rows of a thin triangle need not touch: then their nearest pixels are connected if the path between
    // them meets no discontinuity.
    void bridge(const std::vector<PixelRow>& rows, std::size_t r) {
        const PixelRow &upper = rows[r - 1], &lower = rows[r];
        if (upper.y + 1 == lower.y && upper.first <= lower.end && lower.first <= upper.end) return;
        int x0 = std::max(upper.first, lower.first), x1 = x0;  // a column of both rows
        if (lower.end <= upper.first) x0 = upper.first, x1 = lower.end - 1;
        if (upper.end <= lower.first) x0 = upper.end - 1, x1 = lower.first;
        const auto centre = [](int x, int y) {
            return Vec2f{static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f};
        };
        if (discontinuities_between(s_, centre(x0, upper.y), centre(x1, lower.y)).empty())
            join(number(rows, r - 1, x0), number(rows, r, x1));
    }

    const Surfaces& s_;
    std::vector<std::size_t> names_;
};

// Returns the squared, near-weighted error of a pixel outside the label, whose disparity is `mean`: of at
// most 10 px, and more if the triangle hides a farther surface.
double outlier_cost(double d, double mean, double nearest_px) {
    const double error = d > 0 && mean > 0 ? std::min(std::fabs(d - mean), 10.0) : 10.0;
    const double near = (d > 0 ? d : 0.7 * mean) / nearest_px;
    return near * near * near * error * error * (d > 0 && d < mean ? 4.0 : 1.0);
}

// True if a triangle has two outliers or more, and they cost more than 0.5 px2 for each pixel
// of a lattice cell.
bool is_straddling(const Surfaces& s, const std::vector<std::size_t>& inside,
                   const std::vector<std::size_t>& outliers, double cell_px) {
    if (outliers.size() < 2) return false;
    const float nearest_px = *std::max_element(s.disparity.begin(), s.disparity.end());
    double sum = 0, cost = 0;
    for (const std::size_t i : inside) sum += s.disparity[i];
    const double mean = sum / static_cast<double>(inside.size());
    for (const std::size_t i : outliers)
        if (s.trusted[i]) cost += outlier_cost(s.disparity[i], mean, nearest_px);
    return cost > 0.5 * cell_px;
}

// True if a triangle's rows follow each other, each with a column in common with the one above, and no pixel
// has a discontinuity on its right or below it.
bool is_plain(const Surfaces& s, const std::vector<PixelRow>& rows) {
    for (std::size_t r = 0; r < rows.size(); ++r) {
        const PixelRow& row = rows[r];
        if (r > 0 && (rows[r - 1].y + 1 != row.y ||
                      std::max(rows[r - 1].first, row.first) >= std::min(rows[r - 1].end, row.end)))
            return false;
        for (int x = row.first; x < row.end; ++x)
            if (s.has({x, row.y, false}) || s.has({x, row.y, true})) return false;
    }
    return !rows.empty();
}

// Returns the pixel at the centre of a triangle without pixels.
std::size_t middle_pixel(const Surfaces& s, const std::array<Vec2f, 3>& c) {
    return s.index(std::clamp(static_cast<int>((c[0].x + c[1].x + c[2].x) / 3), 0, s.width - 1),
                   std::clamp(static_cast<int>((c[0].y + c[1].y + c[2].y) / 3), 0, s.height - 1));
}

}  // namespace

Labels label_triangles(const Surfaces& s, const PlaneMesh& mesh, double cell_px) {
    Labels labels{std::vector<int>(s.disparity.size(), -1),
                  std::vector<bool>(s.disparity.size(), false),
                  {},
                  {},
                  {},
                  {}};
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const Triangle& v = mesh.triangles[t];
        const std::array<Vec2f, 3> corners{mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]]};
        const std::vector<PixelRow> rows = rows_of(s, corners);
        const Components components(s, rows);
        std::vector<std::size_t> inside, outliers;
        const std::size_t largest = components.largest();
        std::size_t number = 0;
        for (const PixelRow& row : rows)
            for (int x = row.first; x < row.end; ++x) {
                const std::size_t i = s.index(x, row.y);
                labels.triangle[i] = static_cast<int>(t);
                labels.in_label[i] = components.name(number++) == largest;
                (labels.in_label[i] ? inside : outliers).push_back(i);
            }
        labels.anchor.push_back(inside.empty() ? middle_pixel(s, corners) : inside[0]);
        labels.kept.push_back(s.disparity[labels.anchor[t]] > 0);
        labels.straddling.push_back(is_straddling(s, inside, outliers, cell_px));
        labels.plain.push_back(is_plain(s, rows));
    }
    return labels;
}

}  // namespace hexrelief::surface::oracle
