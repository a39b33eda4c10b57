// Step 15: disparities of the vertices, by least squares against each triangle's own pixels.
#include <algorithm>
#include <cmath>
#include <optional>

#include "parts.h"

namespace hexrelief::oracle {
namespace {

struct FitPixel {
    int x, y;
    float disparity;
    bool behind_low_step;
};

// Where a vertex begins, and the bounds that it keeps.
struct Start {
    double disparity;
    float least, most;
};

// One triangle's normal equations, for the barycentric coordinates of its pixels.
struct Equations {
    double matrix[3][3] = {}, right[3] = {};
};

// Within two pixels behind a discontinuity that goes down to the right by less than 6 px.
bool is_behind_low_step(const Surfaces& s, int x, int y) {
    for (int k = 1; k <= 2; ++k) {
        const CrackEdge c{x - k, y, false};
        if (!s.has(c)) continue;
        return s.second(c) > 0 && s.first(c) > s.second(c) && s.first(c) - s.second(c) < 6;
    }
    return false;
}

// Of each triangle: those in its label that are no speckle's.
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

// Triangles with a corner at the vertex.
std::vector<std::vector<std::size_t>> triangles_at(const CutMesh& mesh) {
    std::vector<std::vector<std::size_t>> at(mesh.points.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (const std::uint32_t v : mesh.triangles[t]) at[v].push_back(t);
    return at;
}

// Sums over pixels, whose coordinates are whole numbers, and what a plane through them needs.
class PlaneFit {
  public:
    void add(const FitPixel& p) {
        const double x = p.x, y = p.y, d = p.disparity;
        n_ += 1, x_ += x, y_ += y, xx_ += x * x, xy_ += x * y, yy_ += y * y;
        d_ += d, xd_ += x * d, yd_ += y * d;
        least_ = std::min(least_, p.disparity);
        most_ = std::max(most_, p.disparity);
    }
    bool empty() const { return n_ == 0; }
    float least() const { return least_; }
    float most() const { return most_; }
    // Six pixels at least, and not all about in a row.
    bool holds_plane() const {
        if (n_ < 6) return false;
        const double xx = xx_ - x_ * x_ / n_, xy = xy_ - x_ * y_ / n_, yy = yy_ - y_ * y_ / n_;
        return xx * yy - xy * xy > 0.05 * (xx + yy) * (xx + yy) && xx + yy > 2;
    }
    // The plane's disparity, or the pixels' mean where they hold none; at most `reach` px beyond their range.
    double at(const Vec2f& p, float reach) const {
        double gx = 0, gy = 0;
        if (holds_plane()) {
            const double xx = xx_ - x_ * x_ / n_, xy = xy_ - x_ * y_ / n_, yy = yy_ - y_ * y_ / n_;
            const double xd = xd_ - x_ * d_ / n_, yd = yd_ - y_ * d_ / n_, determinant = xx * yy - xy * xy;
            gx = (xd * yy - yd * xy) / determinant;
            gy = (yd * xx - xd * xy) / determinant;
        }
        const double at = d_ / n_ + gx * (double(p.x) - 0.5 - x_ / n_) + gy * (double(p.y) - 0.5 - y_ / n_);
        return std::clamp(at, static_cast<double>(least_) - reach, static_cast<double>(most_) + reach);
    }

  private:
    double n_ = 0, x_ = 0, y_ = 0, xx_ = 0, xy_ = 0, yy_ = 0, d_ = 0, xd_ = 0, yd_ = 0;
    float least_ = 3.0e38f, most_ = -3.0e38f;
};

// The floor of all disparities: half of the smallest one that the map has.
double lowest_disparity(const Surfaces& s) {
    float smallest = std::numeric_limits<float>::max();
    for (const float d : s.disparity)
        if (d > 0) smallest = std::min(smallest, d);
    return std::max(1e-3, 0.5 * static_cast<double>(smallest));
}

float longest_edge_at(const CutMesh& mesh, const std::vector<std::size_t>& triangles, std::size_t v) {
    float longest2 = 0;
    for (const std::size_t t : triangles)
        for (const std::uint32_t u : mesh.triangles[t]) {
            const float dx = mesh.points[u].x - mesh.points[v].x, dy = mesh.points[u].y - mesh.points[v].y;
            longest2 = std::max(longest2, dx * dx + dy * dy);
        }
    return std::sqrt(longest2);
}

// From the plane of the pixels of the triangles at a vertex; where these hold none, of those at all corners
// of these triangles, counted as often as they are reached so. None: there are no such pixels.
std::optional<Start> start_at(const CutMesh& mesh, const std::vector<std::vector<FitPixel>>& pixels,
                              const std::vector<std::vector<std::size_t>>& at, std::size_t v, double floor) {
    PlaneFit plane, wide;
    for (const std::size_t t : at[v]) {
        for (const FitPixel& p : pixels[t]) plane.add(p);
        for (const std::uint32_t u : mesh.triangles[t])
            for (const std::size_t other : at[u])
                for (const FitPixel& p : pixels[other]) wide.add(p);
    }
    if (!plane.holds_plane()) plane = wide;
    if (plane.empty()) return std::nullopt;
    const float longest = longest_edge_at(mesh, at[v], v), slack = 1.5f + 0.25f * longest;
    Start start;
    start.least = std::max({0.5f * plane.least(), plane.least() - slack, static_cast<float>(floor)});
    start.most = std::max(start.least, plane.most() + slack);
    start.disparity = std::clamp<double>(plane.at(mesh.points[v], longest), start.least, start.most);
    return start;
}

// Vertices without pixels: ring by ring the mean of their neighbours, counted once a triangle; where a whole
// connected component has none, its triangles' own surface.
void start_without_pixels(const Surfaces& s, const Labels& labels, const CutMesh& mesh,
                          const std::vector<std::vector<std::size_t>>& at, double floor,
                          std::vector<std::optional<Start>>& starts) {
    const auto fixed = [](double d) { return Start{d, static_cast<float>(d), static_cast<float>(d)}; };
    for (bool any = true; any;) {
        const std::vector<std::optional<Start>> before = starts;
        any = false;
        for (std::size_t v = 0; v < starts.size(); ++v) {
            if (before[v]) continue;
            double sum = 0;
            int count = 0;
            for (const std::size_t t : at[v])
                for (const std::uint32_t u : mesh.triangles[t])
                    if (before[u]) sum += before[u]->disparity, ++count;
            if (count > 0) starts[v] = fixed(sum / count), any = true;
        }
    }
    for (std::size_t v = 0; v < starts.size(); ++v)
        if (!starts[v])
            starts[v] = fixed(
                std::max<double>(floor, s.disparity[labels.anchor[mesh.source_triangles[at[v].front()]]]));
}

// Huber's weight by what the pixel differs from where the vertices begin, beyond 1 px; 20 behind a low step.
double weight_of(const FitPixel& p, double start) {
    const double residual = std::fabs(start - p.disparity);
    return p.behind_low_step ? 20 : residual > 1 ? 1 / residual : 1;
}

Equations equations_of(const std::array<Vec2f, 3>& c, const std::array<double, 3>& starts,
                       const std::vector<FitPixel>& pixels) {
    Equations e;
    const double abx = double(c[1].x) - c[0].x, aby = double(c[1].y) - c[0].y, acx = double(c[2].x) - c[0].x,
                 acy = double(c[2].y) - c[0].y, area2 = abx * acy - aby * acx;
    for (const FitPixel& p : pixels) {
        const double x = p.x + 0.5 - c[0].x, y = p.y + 0.5 - c[0].y;
        const double lb = (x * acy - y * acx) / area2, lc = (abx * y - aby * x) / area2;
        const double l[3] = {1 - lb - lc, lb, lc};
        const double w = weight_of(p, l[0] * starts[0] + l[1] * starts[1] + l[2] * starts[2]);
        for (int j = 0; j < 3; ++j) {
            for (int k = 0; k < 3; ++k) e.matrix[j][k] += w * l[j] * l[k];
            e.right[j] += w * l[j] * p.disparity;
        }
    }
    return e;
}

// One damped Jacobi sweep of all vertices, each pulled to where it began by 0.05 of a pixel's weight.
std::vector<double> sweep(const CutMesh& mesh, const std::vector<Equations>& equations,
                          const std::vector<std::optional<Start>>& starts,
                          const std::vector<double>& values) {
    std::vector<double> diagonal(values.size(), 0.05), right, relaxed;
    for (const std::optional<Start>& start : starts) right.push_back(0.05 * start->disparity);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (int j = 0; j < 3; ++j) {
            const std::uint32_t v = mesh.triangles[t][j];
            diagonal[v] += equations[t].matrix[j][j];
            right[v] += equations[t].right[j];
            for (int k = 0; k < 3; ++k)
                if (k != j) right[v] -= equations[t].matrix[j][k] * values[mesh.triangles[t][k]];
        }
    for (std::size_t v = 0; v < values.size(); ++v)
        relaxed.push_back(std::clamp<double>(values[v] + 0.8 * (right[v] / diagonal[v] - values[v]),
                                             starts[v]->least, starts[v]->most));
    return relaxed;
}

}  // namespace

std::vector<float> fit_disparities(const Surfaces& s, const Labels& labels, const CutMesh& mesh) {
    const double floor = lowest_disparity(s);
    const std::vector<std::vector<FitPixel>> pixels = pixels_of(s, labels, mesh);
    const std::vector<std::vector<std::size_t>> at = triangles_at(mesh);
    std::vector<std::optional<Start>> starts;
    for (std::size_t v = 0; v < mesh.points.size(); ++v)
        starts.push_back(start_at(mesh, pixels, at, v, floor));
    start_without_pixels(s, labels, mesh, at, floor, starts);
    std::vector<double> values;
    for (const std::optional<Start>& start : starts) values.push_back(start->disparity);
    std::vector<Equations> equations;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto& [a, b, c] = mesh.triangles[t];
        equations.push_back(equations_of({mesh.points[a], mesh.points[b], mesh.points[c]},
                                         {values[a], values[b], values[c]}, pixels[t]));
    }
    for (int i = 0; i < 4; ++i) values = sweep(mesh, equations, starts, values);
    return {values.begin(), values.end()};
}

}  // namespace hexrelief::oracle
