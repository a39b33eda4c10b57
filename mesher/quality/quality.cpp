#include "mesher/quality/quality.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "mesher/quality/exact_cell_mass.h"
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

}  // namespace hexrelief::quality
