#include "mesher/quality/exact_cell_mass.h"

#include <algorithm>
#include <cmath>

#include "mesher/common/lattice_step.h"
#include "pipeline/base/thread_pool.h"

namespace hexrelief::quality {
namespace {

// The density's primitive along rows: value(row, x) is the integral of a row from 0 to x.
class RowPrimitive {
  public:
    RowPrimitive(const DensityMap& density, ThreadPool& pool)
        : width_(density.width), height_(density.height), sums_(0) {
        sums_.resize(static_cast<std::size_t>(width_ + 1) * height_);
        pool.parallel_for(height_, [&](std::size_t first, std::size_t last) {
            for (std::size_t y = first; y < last; ++y) {
                double* const row = &sums_[y * (width_ + 1)];
                row[0] = 0;
                for (int x = 0; x < width_; ++x) row[x + 1] = row[x] + density.at(x, static_cast<int>(y));
            }
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

EdgeMasses::EdgeMasses(const HexMesh2D& mesh, const DensityMap& density, int threads)
    : columns_(mesh.columns), mass_(mesh.positions.size()) {
    ThreadPool pool(threads);
    const RowPrimitive primitive(density, pool);
    pool.parallel_for(mesh.rows, [&](std::size_t first, std::size_t last) {
        for (int row = static_cast<int>(first); row < static_cast<int>(last); ++row)
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
