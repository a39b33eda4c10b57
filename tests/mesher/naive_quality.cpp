#include "tests/mesher/naive_quality.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace hexrelief::testing_mesher {
namespace {

struct Point {
    double x, y;
};
using Polygon = std::vector<Point>;

double signed_area(const Polygon& p) {
    double sum = 0;
    for (std::size_t i = 0; i < p.size(); ++i) {
        const Point &a = p[i], &b = p[(i + 1) % p.size()];
        sum += a.x * b.y - a.y * b.x;
    }
    return sum / 2;
}

// Returns the part of the polygon with nx * x + ny * y <= limit (Sutherland and Hodgman).
Polygon clip(const Polygon& polygon, double nx, double ny, double limit) {
    Polygon result;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Point &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
        const double da = nx * a.x + ny * a.y - limit, db = nx * b.x + ny * b.y - limit;
        if (da <= 0) result.push_back(a);
        if ((da < 0 && db > 0) || (da > 0 && db < 0)) {
            const double t = da / (da - db);
            result.push_back({a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)});
        }
    }
    return result;
}

double mass(const Polygon& triangle, const DensityMap& density) {
    double sum = 0;
    for (int y = 0; y < density.height; ++y)
        for (int x = 0; x < density.width; ++x) {
            Polygon part = clip(triangle, -1, 0, -x);
            part = clip(part, 1, 0, x + 1.0);
            part = clip(part, 0, -1, -y);
            part = clip(part, 0, 1, y + 1.0);
            sum += std::abs(signed_area(part)) * density.at(x, y);
        }
    return sum;
}

struct Site {
    int column, row;
};

// Returns the position of a vertex in the undeformed lattice with spacing 1.
Point undeformed(const Site& s) {
    return {s.column + (s.row % 2 == 1 ? 0.5 : 0.0), s.row * std::sqrt(3.0) / 2};
}

// Returns the existing vertices at one spacing, sorted by angle.
std::vector<Site> ring(const HexMesh2D& mesh, const Site& centre) {
    const Point c = undeformed(centre);
    std::vector<Site> sites;
    for (int row = 0; row < mesh.rows; ++row)
        for (int column = 0; column < mesh.columns; ++column) {
            const Point p = undeformed({column, row});
            if (std::abs(std::hypot(p.x - c.x, p.y - c.y) - 1) < 0.01) sites.push_back({column, row});
        }
    const auto angle = [&](const Site& s) {
        return std::atan2(undeformed(s).y - c.y, undeformed(s).x - c.x);
    };
    std::sort(sites.begin(), sites.end(), [&](const Site& a, const Site& b) { return angle(a) < angle(b); });
    return sites;
}

Point position(const HexMesh2D& mesh, const Site& s) {
    return {mesh.at(s.column, s.row).x, mesh.at(s.column, s.row).y};
}

// Measures each triangle of the lattice: the undeformed triples at mutual distance 1,
// oriented to positive area.
void measure_triangles(const HexMesh2D& mesh, NaiveQuality& quality) {
    for (int row = 0; row < mesh.rows; ++row)
        for (int column = 0; column < mesh.columns; ++column) {
            const Site a{column, row};
            const std::vector<Site> around = ring(mesh, a);
            for (const Site& b : around)
                for (const Site& c : around) {
                    const auto index = [&](const Site& s) { return mesh.index(s.column, s.row); };
                    if (index(a) > index(b) || index(a) > index(c)) continue;
                    const Point pb = undeformed(b), pc = undeformed(c);
                    if (std::abs(std::hypot(pb.x - pc.x, pb.y - pc.y) - 1) > 0.01) continue;
                    if (signed_area({undeformed(a), pb, pc}) < 0) continue;
                    const Polygon t{position(mesh, a), position(mesh, b), position(mesh, c)};
                    quality.inverted += signed_area(t) <= 0;
                    double smallest_deg = 180;
                    for (int i = 0; i < 3; ++i) {
                        const Point &p = t[i], &q = t[(i + 1) % 3], &r = t[(i + 2) % 3];
                        const double dot = (q.x - p.x) * (r.x - p.x) + (q.y - p.y) * (r.y - p.y);
                        const double lengths =
                            std::hypot(q.x - p.x, q.y - p.y) * std::hypot(r.x - p.x, r.y - p.y);
                        const double angle = std::acos(std::clamp(dot / lengths, -1.0, 1.0));
                        smallest_deg = std::min(smallest_deg, angle * 180 / std::numbers::pi);
                    }
                    quality.angles_deg.push_back(smallest_deg);
                    quality.min_angle_deg = std::min(quality.min_angle_deg, smallest_deg);
                }
        }
}

}  // namespace

NaiveQuality naive_quality(const HexMesh2D& mesh, const DensityMap& density) {
    NaiveQuality quality;
    measure_triangles(mesh, quality);
    for (int row = 0; row < mesh.rows; ++row)
        for (int column = 0; column < mesh.columns; ++column) {
            const int q = column - (row - row % 2) / 2;
            if ((q - row) % 3 != 0) continue;
            const std::vector<Site> around = ring(mesh, {column, row});
            if (around.size() != 6) continue;
            double weight = 0;
            for (int k = 0; k < 6; ++k)
                weight += mass({position(mesh, {column, row}), position(mesh, around[k]),
                                position(mesh, around[(k + 1) % 6])},
                               density);
            quality.weights.push_back(weight);
        }
    double mean = 0;
    for (const double w : quality.weights) mean += w / static_cast<double>(quality.weights.size());
    if (!(mean > 0)) return quality;
    for (const double w : quality.weights) {
        const double percent = 100 * std::abs(w - mean) / mean;
        quality.percent_cost += percent / static_cast<double>(quality.weights.size());
        quality.max_deviation_percent = std::max(quality.max_deviation_percent, percent);
    }
    return quality;
}

}  // namespace hexrelief::testing_mesher
