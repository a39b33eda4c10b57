#include "mesher/quality/quality.h"

#include <algorithm>
#include <cmath>

#include "mesher/common/lattice_step.h"
#include "pipeline/base/thread_pool.h"
#include "pipeline/data/start_work.h"

namespace hexrelief::quality {
namespace {

double twice_area(const Vec2f& a, const Vec2f& b, const Vec2f& c) {
    return (static_cast<double>(b.x) - a.x) * (static_cast<double>(c.y) - a.y) -
           (static_cast<double>(b.y) - a.y) * (static_cast<double>(c.x) - a.x);
}

double smallest_angle_deg(const Vec2f& a, const Vec2f& b, const Vec2f& c) {
    const Vec2f corner[3] = {a, b, c};
    double best = 180;
    for (int i = 0; i < 3; ++i) {
        const Vec2f &p = corner[i], &q = corner[(i + 1) % 3], &s = corner[(i + 2) % 3];
        const double ux = static_cast<double>(q.x) - p.x, uy = static_cast<double>(q.y) - p.y;
        const double vx = static_cast<double>(s.x) - p.x, vy = static_cast<double>(s.y) - p.y;
        best = std::min(best, std::abs(std::atan2(ux * vy - uy * vx, ux * vx + uy * vy)) * 57.29577951308232);
    }
    return best;
}

// Returns a percentile of `values`, which must not be empty, and reorders them.
double percentile(std::vector<double>& values, std::size_t percent) {
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() * percent / 100);
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

// Measures the triangles: their angles, and how many are inverted.
MeshQuality measure_triangles(const HexMesh2D& mesh) {
    MeshQuality quality;
    std::vector<double> angles;
    angles.reserve(mesh.triangle_count());
    for (int row = 0; row + 1 < mesh.rows; ++row)
        for (int column = 0; column + 1 < mesh.columns; ++column)
            for (const Triangle& t : quad_triangles(mesh.columns, column, row)) {
                const Vec2f &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
                quality.inverted_triangles += twice_area(a, b, c) <= 0;
                angles.push_back(smallest_angle_deg(a, b, c));
            }
    if (angles.empty()) return quality;
    quality.min_angle_deg = *std::min_element(angles.begin(), angles.end());
    quality.percentile1_angle_deg = percentile(angles, 1);
    quality.median_angle_deg = percentile(angles, 50);
    return quality;
}

// The density's primitive along rows: value(row, x) is the integral of a row from 0 to x.
class RowPrimitive {
  public:
    RowPrimitive(const DensityMap& density, ThreadPool& pool)
        : width_(density.width), height_(density.height), sums_(0) {
        sums_.resize(static_cast<std::size_t>(width_ + 1) * height_);
        pool.parallel_for_each(height_, [&](std::size_t y) {
            double* const row = &sums_[y * (width_ + 1)];
            row[0] = 0;
            for (int x = 0; x < width_; ++x) row[x + 1] = row[x] + density.at(x, static_cast<int>(y));
        });
    }

    // Returns the integral of value(y, x(y)) dy along the segment from a to b. It is exact, because the
    // primitive is linear in x within a pixel.
    double along(const Vec2f& a, const Vec2f& b) const {
        double x0 = a.x, y0 = a.y, x1 = b.x, y1 = b.y, sign = 1;
        if (y0 == y1) return 0;
        if (y0 > y1) {
            std::swap(x0, x1);
            std::swap(y0, y1);
            sign = -1;
        }
        const double slope = (x1 - x0) / (y1 - y0);
        double total = 0;
        const int first = std::clamp(static_cast<int>(std::floor(y0)), 0, height_ - 1);
        const int last = std::clamp(static_cast<int>(std::floor(y1)), 0, height_ - 1);
        for (int row = first; row <= last; ++row) {
            const double top = std::max(y0, static_cast<double>(row)), bottom = std::min(y1, row + 1.0);
            if (bottom <= top) continue;
            total += within_row(row, x0 + (top - y0) * slope, x0 + (bottom - y0) * slope, bottom - top);
        }
        return sign * total;
    }

  private:
    double value(int row, double x) const {
        const int column = std::clamp(static_cast<int>(x), 0, width_ - 1);
        const double* const p = &sums_[static_cast<std::size_t>(row) * (width_ + 1) + column];
        return p[0] + (x - column) * (p[1] - p[0]);
    }

    // Adds up trapezoids between the pixel borders that the segment crosses within one row.
    double within_row(int row, double xa, double xb, double height) const {
        if (xa > xb) std::swap(xa, xb);
        const int first = static_cast<int>(std::floor(xa)), last = static_cast<int>(std::floor(xb));
        if (first == last || xb - xa < 1e-12) return 0.5 * (value(row, xa) + value(row, xb)) * height;
        double total = 0, from = xa, at_from = value(row, xa);
        for (int column = first + 1; column <= last + 1; ++column) {
            const double to = std::min(xb, static_cast<double>(column));
            const double at_to = value(row, to);
            total += 0.5 * (at_from + at_to) * (to - from);
            from = to;
            at_from = at_to;
        }
        return total * height / (xb - xa);
    }

    int width_, height_;
    std::vector<double> sums_;
};

}  // namespace

std::vector<double> honeycomb_weights(const HexMesh2D& mesh, const DensityMap& density, int threads) {
    const EdgeMasses edges(mesh, density, threads);
    std::vector<double> weights;
    for (int row = 1; row + 1 < mesh.rows; ++row)
        for (int column = 0; column < mesh.columns; ++column) {
            const int odd = row & 1, q = column - (row - odd) / 2;
            if (((q - row) % 3 + 3) % 3 != 0) continue;
            const bool inner = column > 0 && column + 1 < mesh.columns;  // then all six neighbours exist
            if (!inner) continue;
            weights.push_back(edges.honeycomb(column, row));
        }
    return weights;
}

MeshQuality measure_quality(const HexMesh2D& mesh, const DensityMap& density, int threads) {
    auto triangles = start_work(threads, [&] { return measure_triangles(mesh); });
    std::vector<double> weights = honeycomb_weights(mesh, density, threads);
    MeshQuality quality = triangles.get();
    quality.honeycomb_cells = static_cast<int>(weights.size());
    double sum = 0, deviation = 0, largest = 0;
    for (const double w : weights) sum += w;
    const double mean = weights.empty() ? 0 : sum / static_cast<double>(weights.size());
    if (!(mean > 0)) return quality;
    for (const double w : weights) {
        deviation += std::abs(w - mean);
        largest = std::max(largest, std::abs(w - mean));
    }
    quality.percent_cost = 100 * deviation / sum;
    quality.max_deviation_percent = 100 * largest / mean;
    quality.percentile5_weight_percent = 100 * percentile(weights, 5) / mean;
    quality.percentile50_weight_percent = 100 * percentile(weights, 50) / mean;
    quality.percentile95_weight_percent = 100 * percentile(weights, 95) / mean;
    return quality;
}

EdgeMasses::EdgeMasses(const HexMesh2D& mesh, const DensityMap& density, int threads)
    : columns_(mesh.columns), mass_(mesh.positions.size()) {
    ThreadPool pool(threads);
    const RowPrimitive primitive(density, pool);
    pool.parallel_for_each(mesh.rows, [&](int row) {
        for (int column = 0; column < mesh.columns; ++column)
            for (int k = 0; k < 3; ++k) {
                const step::Offset o = step::neighbour_offset(row, k);
                const int c = column + o.column, r = row + o.row;
                const bool exists = c >= 0 && c < mesh.columns && r < mesh.rows;
                mass_[mesh.index(column, row)][k] =
                    exists ? primitive.along(mesh.at(column, row), mesh.at(c, r)) : 0;
            }
    });
}

double EdgeMasses::honeycomb(int column, int row) const {
    struct Vertex {
        int column, row;
    };
    const auto neighbour = [&](int k) {
        const step::Offset o = step::neighbour_offset(row, k);
        return Vertex{column + o.column, row + o.row};
    };
    // Returns the integral from vertex v to its neighbour k, 0 <= k < 6. Those for k >= 3 are
    // stored at the neighbour.
    const auto edge = [&](const Vertex& v, int k) {
        if (k < 3) return mass_[static_cast<std::size_t>(v.row) * columns_ + v.column][k];
        const step::Offset o = step::neighbour_offset(v.row, k);
        return -mass_[static_cast<std::size_t>(v.row + o.row) * columns_ + v.column + o.column][k - 3];
    };
    const Vertex centre{column, row};
    double weight = 0;
    // triangles centre -> neighbour k -> neighbour k + 1; the edge on the cell's boundary has direction k + 2
    for (int k = 0; k < 6; ++k)
        weight += std::abs(edge(centre, k) + edge(neighbour(k), (k + 2) % 6) - edge(centre, (k + 1) % 6));
    return weight;
}

}  // namespace hexrelief::quality
