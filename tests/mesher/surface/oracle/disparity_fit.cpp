// Step 15: disparities of the vertices, by least squares against each triangle's own pixels.
#include <algorithm>
#include <cmath>
#include <limits>

#include "oracle_parts.h"

namespace hexrelief::surface::oracle {
namespace {

struct FitPixel {
    int x, y;
    float disparity;
    bool behind_low_step;
};

// One triangle's normal equations, for the barycentric coordinates of its pixels.
struct Equations {
    double matrix[3][3] = {}, right[3] = {};
};

// True within two pixels behind a discontinuity that goes down to the right by less than 4 px.
bool is_behind_low_step(const Surfaces& s, int x, int y) {
    for (int k = 1; k <= 2; ++k) {
        const CrackEdge c{x - k, y, false};
        if (!s.has(c)) continue;
        return s.second(c) > 0 && s.first(c) > s.second(c) && s.first(c) - s.second(c) < 4;
    }
    return false;
}

// Returns for each triangle the pixels of its label that are not speckles.
std::vector<std::vector<FitPixel>> pixels_of(const Surfaces& s, const Labels& labels, const CutMesh& mesh) {
    std::vector<std::vector<FitPixel>> by_source(labels.kept.size()), pixels;
    for (int y = 0; y < s.height; ++y)
        for (int x = 0; x < s.width; ++x) {
            const std::size_t i = s.index(x, y);
            if (labels.triangle[i] >= 0 && labels.in_label[i] && s.trusted[i])
                by_source[labels.triangle[i]].push_back({x, y, s.disparity[i], is_behind_low_step(s, x, y)});
        }
    for (const std::uint32_t t : mesh.source_triangles) pixels.push_back(by_source[t]);
    return pixels;
}

// Returns the triangles with a corner at each vertex.
std::vector<std::vector<std::size_t>> triangles_at(const CutMesh& mesh) {
    std::vector<std::vector<std::size_t>> at(mesh.points.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (const std::uint32_t v : mesh.triangles[t]) at[v].push_back(t);
    return at;
}

// Sums over pixels, whose coordinates are integers, and the plane through them.
class PlaneFit {
  public:
    // Coordinates are counted from the vertex's pixel.
    explicit PlaneFit(const Vec2f& vertex) : column_(std::floor(vertex.x)), row_(std::floor(vertex.y)) {}
    void add(const FitPixel& p) {
        const double x = p.x - column_, y = p.y - row_, d = p.disparity;
        n_ += 1, x_ += x, y_ += y, xx_ += x * x, xy_ += x * y, yy_ += y * y;
        d_ += d, xd_ += x * d, yd_ += y * d;
    }
    bool empty() const { return n_ == 0; }
    // True if there are at least six pixels that are not all nearly in a row.
    bool holds_plane() const {
        if (n_ < 6) return false;
        const double xx = xx_ - x_ * x_ / n_, xy = xy_ - x_ * y_ / n_, yy = yy_ - y_ * y_ / n_;
        return xx * yy - xy * xy > 0.05 * (xx + yy) * (xx + yy) && xx + yy > 2;
    }
    // Returns the plane's disparity, or the pixels' mean if they hold no plane.
    double at(const Vec2f& p) const {
        double gx = 0, gy = 0;
        if (holds_plane()) {
            const double xx = xx_ - x_ * x_ / n_, xy = xy_ - x_ * y_ / n_, yy = yy_ - y_ * y_ / n_;
            const double xd = xd_ - x_ * d_ / n_, yd = yd_ - y_ * d_ / n_, determinant = xx * yy - xy * xy;
            gx = (xd * yy - yd * xy) / determinant;
            gy = (yd * xx - xd * xy) / determinant;
        }
        return d_ / n_ + gx * (p.x - column_ - 0.5 - x_ / n_) + gy * (p.y - row_ - 0.5 - y_ / n_);
    }

  private:
    double column_, row_;
    double n_ = 0, x_ = 0, y_ = 0, xx_ = 0, xy_ = 0, yy_ = 0, d_ = 0, xd_ = 0, yd_ = 0;
};

// Returns the least disparity of a vertex: half of the smallest one in the map.
double lowest_disparity(const Surfaces& s) {
    float smallest = std::numeric_limits<float>::max();
    for (const float d : s.disparity)
        if (d > 0) smallest = std::min(smallest, d);
    return std::max(1e-3, 0.5 * static_cast<double>(smallest));
}

// Returns the value on the plane of the pixels of the triangles at the vertex; without such pixels, that of
// a triangle's own surface.
double start_at(const Surfaces& s, const Labels& labels, const CutMesh& mesh,
                const std::vector<std::vector<FitPixel>>& pixels, const std::vector<std::size_t>& triangles,
                std::size_t v) {
    PlaneFit plane(mesh.points[v]);
    for (const std::size_t t : triangles)
        for (const FitPixel& p : pixels[t]) plane.add(p);
    return plane.empty() ? s.disparity[labels.anchor[mesh.source_triangles[triangles.front()]]]
                         : plane.at(mesh.points[v]);
}

Equations equations_of(const std::array<Vec2f, 3>& c, const std::vector<FitPixel>& pixels) {
    Equations e;
    const double abx = double(c[1].x) - c[0].x, aby = double(c[1].y) - c[0].y, acx = double(c[2].x) - c[0].x,
                 acy = double(c[2].y) - c[0].y, area2 = abx * acy - aby * acx;
    for (const FitPixel& p : pixels) {
        const double x = p.x + 0.5 - c[0].x, y = p.y + 0.5 - c[0].y;
        const double lb = (x * acy - y * acx) / area2, lc = (abx * y - aby * x) / area2;
        const double l[3] = {1 - lb - lc, lb, lc};
        const double w = p.behind_low_step ? 20 : 1;
        for (int j = 0; j < 3; ++j) {
            for (int k = 0; k < 3; ++k) e.matrix[j][k] += w * l[j] * l[k];
            e.right[j] += w * l[j] * p.disparity;
        }
    }
    return e;
}

// Makes one damped Jacobi sweep of all vertices, each drawn to its start value with a weight of 0.05.
std::vector<double> sweep(const CutMesh& mesh, const std::vector<Equations>& equations,
                          const std::vector<double>& starts, double floor,
                          const std::vector<double>& values) {
    std::vector<double> diagonal(values.size(), 0.05), right, relaxed;
    for (const double start : starts) right.push_back(0.05 * start);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (int j = 0; j < 3; ++j) {
            const std::uint32_t v = mesh.triangles[t][j];
            diagonal[v] += equations[t].matrix[j][j];
            right[v] += equations[t].right[j];
            for (int k = 0; k < 3; ++k)
                if (k != j) right[v] -= equations[t].matrix[j][k] * values[mesh.triangles[t][k]];
        }
    for (std::size_t v = 0; v < values.size(); ++v)
        relaxed.push_back(std::max(floor, values[v] + 0.8 * (right[v] / diagonal[v] - values[v])));
    return relaxed;
}

}  // namespace

std::vector<float> fit_disparities(const Surfaces& s, const Labels& labels, const CutMesh& mesh) {
    const double floor = lowest_disparity(s);
    const std::vector<std::vector<FitPixel>> pixels = pixels_of(s, labels, mesh);
    const std::vector<std::vector<std::size_t>> at = triangles_at(mesh);
    std::vector<double> starts;
    for (std::size_t v = 0; v < mesh.points.size(); ++v)
        starts.push_back(std::max(floor, start_at(s, labels, mesh, pixels, at[v], v)));
    std::vector<Equations> equations;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto& [a, b, c] = mesh.triangles[t];
        equations.push_back(equations_of({mesh.points[a], mesh.points[b], mesh.points[c]}, pixels[t]));
    }
    std::vector<double> values = starts;
    for (int i = 0; i < 4; ++i) values = sweep(mesh, equations, starts, floor, values);
    return {values.begin(), values.end()};
}

}  // namespace hexrelief::surface::oracle
