#include "pipeline/stages/surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <string>
#include <utility>

#include "pipeline/data/disparity_map.h"
#include "pipeline/data/error.h"
#include "pipeline/stages/surface_topology.h"

namespace hexrelief::stages {
namespace {

struct Vec3d {
    double x = 0, y = 0, z = 0;
};
Vec3d operator-(const Vec3d& a, const Vec3d& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
Vec3d cross(const Vec3d& a, const Vec3d& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
double dot(const Vec3d& a, const Vec3d& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
double length(const Vec3d& a) {
    return std::sqrt(dot(a, a));
}

void check(const DisparityMesh& cut_mesh, const Calibration& calibration) {
    if (cut_mesh.points.size() != cut_mesh.disparities.size())
        throw Error(ErrorKind::input, "surface: the mesh has " + std::to_string(cut_mesh.points.size()) +
                                          " vertices, but " + std::to_string(cut_mesh.disparities.size()) +
                                          " disparities");
    const auto positive = [](double value) { return std::isfinite(value) && value > 0; };
    if (!positive(calibration.focal_px))
        throw Error(ErrorKind::input, "calibration: focal_px must be above 0");
    if (!positive(calibration.baseline_m))
        throw Error(ErrorKind::input, "calibration: baseline_m must be above 0");
}

// Returns the vertices' positions in space; NaN for those that have none.
std::vector<Vec3d> placed_vertices(const DisparityMesh& cut_mesh, const Calibration& calibration) {
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    std::vector<Vec3d> positions(cut_mesh.points.size(), {none, none, none});
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const float d = cut_mesh.disparities[i];
        if (!std::isfinite(d) || !(d + calibration.doffs_px > 0)) continue;
        const Vec2f& at = cut_mesh.points[i];
        const auto [x, y, z] = position_in_space(at.x, at.y, d, calibration);
        const Vec3d v{x, y, z};
        const auto fits = [](double value) { return std::isfinite(static_cast<float>(value)); };
        if (fits(v.x) && fits(v.y) && fits(v.z)) positions[i] = v;
    }
    return positions;
}

std::vector<Triangle> kept_triangles(const DisparityMesh& cut_mesh, const std::vector<Vec3d>& positions) {
    std::vector<Triangle> triangles;
    triangles.reserve(cut_mesh.triangles.size());
    const auto is_placed = [&](std::uint32_t i) { return !std::isnan(positions[i].z); };
    for (const Triangle& t : cut_mesh.triangles) {
        if (!is_placed(t[0]) || !is_placed(t[1]) || !is_placed(t[2])) continue;
        const Vec2f &a = cut_mesh.points[t[0]], &b = cut_mesh.points[t[1]], &c = cut_mesh.points[t[2]];
        const double area =
            (double(b.x) - a.x) * (double(c.y) - a.y) - (double(b.y) - a.y) * (double(c.x) - a.x);
        // Positive area with y down is clockwise to the viewer, so two vertices are swapped.
        if (area > kDegenerateArea_px) triangles.push_back({t[0], t[2], t[1]});
    }
    return triangles;
}

// Returns the angle between the vector (x, y), y >= 0, and the x axis, to 2e-6 rad. A polynomial for the
// arctangent up to 45 degrees is faster than std::atan2 and rounds in the same way everywhere.
double angle_of(double x, double y) {
    const double size = std::abs(x), high = std::max(size, y), t = high > 0 ? std::min(size, y) / high : 0,
                 s = t * t;
    double angle =
        t *
        (0.999977219 +
         s * (-0.332622828 + s * (0.193540376 + s * (-0.116426482 + s * (0.052647351 - s * 0.011719136)))));
    if (y > size) angle = std::numbers::pi / 2 - angle;
    return x < 0 ? std::numbers::pi - angle : angle;
}

// Sums the triangles' normals at each vertex, weighted by the angle there. Weighted by area, the few long
// triangles on steep flanks would outweigh all others; weighted by the edge lengths that are exact for
// spheres (Max 1999), small triangles would: then normals differ from those of planes through 7 x 7 px of the
// map by 11.4 degrees instead of 9.2 on cones, 15.7 instead of 12.3 on teddy (means).
std::vector<Vec3d> normal_sums(const std::vector<Triangle>& triangles, const std::vector<Vec3d>& positions) {
    std::vector<Vec3d> sums(positions.size());
    for (const Triangle& t : triangles) {
        const Vec3d ab = positions[t[1]] - positions[t[0]], ac = positions[t[2]] - positions[t[0]],
                    bc = positions[t[2]] - positions[t[1]];
        const Vec3d normal = cross(ab, ac);
        const double twice_area = length(normal);
        if (!(twice_area > 0)) continue;
        const double at_a = angle_of(dot(ab, ac), twice_area), at_b = angle_of(-dot(ab, bc), twice_area),
                     at_c = std::max(0.0, std::numbers::pi - at_a - at_b), scale = 1 / twice_area;
        const double weights[3] = {at_a * scale, at_b * scale, at_c * scale};
        for (int k = 0; k < 3; ++k) {
            Vec3d& sum = sums[t[k]];
            sum = {sum.x + weights[k] * normal.x, sum.y + weights[k] * normal.y,
                   sum.z + weights[k] * normal.z};
        }
    }
    return sums;
}

// Returns where each vertex lies in the picture, px, so that what is drawn between the vertices lies there,
// too. Across a triangle in space texture coordinates change evenly, but the picture seen on it does not:
// halfway from a to b its point nearer to the near end by (b - a) (zb - za) / (2 (za + zb)) is drawn. Two
// thirds of that, the mean along an edge, are taken off the vertices, weighted by the triangles' areas in the
// picture. That leaves a quarter to a half of the squared error: 44.5 instead of 40.7 dB on cones, 50.9
// of 47.7 on teddy.
std::vector<Vec2f> drawn_points(const std::vector<Triangle>& triangles, const std::vector<Vec3d>& positions,
                                std::vector<Vec2f> points) {
    constexpr double kMost_px = 0.5;
    std::vector<Vec3d> sums(points.size());  // of x, y, and weights
    for (const Triangle& t : triangles) {
        const Vec2f &a = points[t[0]], &b = points[t[1]], &c = points[t[2]];
        const double area =
            (double(c.x) - a.x) * (double(b.y) - a.y) - (double(c.y) - a.y) * (double(b.x) - a.x);
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t i = t[k], j = t[(k + 1) % 3];
            const double z = positions[i].z, other = positions[j].z,
                         weight = area * (other - z) / (2 * (z + other));
            const double x = weight * (double(points[j].x) - points[i].x),
                         y = weight * (double(points[j].y) - points[i].y);
            for (const std::uint32_t v : {i, j}) sums[v] = {sums[v].x + x, sums[v].y + y, sums[v].z + area};
        }
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto moved = [&](double sum) {
            return static_cast<float>(std::clamp(2.0 / 3 * sum / sums[i].z, -kMost_px, kMost_px));
        };
        points[i] = {points[i].x + moved(sums[i].x), points[i].y + moved(sums[i].y)};
    }
    return points;
}

Vec3f unit_normal(Vec3d n, const Vec3d& position) {
    double size = length(n);
    if (!(size > 0)) {
        // All triangles face the camera, hence so does the sum; only underflow can make it vanish.
        n = {-position.x, -position.y, -position.z};
        size = length(n);
    }
    return {float(n.x / size), float(n.y / size), float(n.z / size)};
}

// How far means reach: gradients at the ends of an edge may differ by so many times the noise, or the
// quantum, over the edge.
constexpr double kOfNoise = 4, kOfQuantum = 0.25;
constexpr int kRounds = 5, kRoundsOfQuantum = 4;

struct Gradient {
    double x = 0, y = 0;  // px of disparity per px
};

// A side of a triangle; inner edges have two.
struct Side {
    std::uint32_t a, b;
    double length2;  // px^2
};

// The plane through p with normal n, in disparities: f b = d Z, X = (x - cx) Z / f and so on.
Gradient gradient_of(const Vec3f& n, const Vec3f& p, double baseline) {
    const double towards = -(double(n.x) * p.x + double(n.y) * p.y + double(n.z) * p.z);
    if (!(towards > 0)) return {};
    return {-n.x * baseline / towards, n.y * baseline / towards};
}

Vec3f normal_of(const Gradient& g, const Vec2f& at, float disparity, const Calibration& camera) {
    const double x = -g.x * camera.focal_px, y = g.y * camera.focal_px,
                 z = disparity + camera.doffs_px - g.x * (at.x - camera.cx) - g.y * (at.y - camera.cy);
    const double length = std::sqrt(x * x + y * y + z * z);
    return {float(x / length), float(y / length), float(z / length)};
}

// Returns the median of what the gradients leave of the differences along the sides, px.
double noise_of(const SurfaceMesh& mesh, const std::vector<Side>& sides,
                const std::vector<Gradient>& gradients) {
    std::vector<double> left(sides.size());
    for (std::size_t i = 0; i < sides.size(); ++i) {
        const std::uint32_t a = sides[i].a, b = sides[i].b;
        const Vec2f &p = mesh.image_points[a], &q = mesh.image_points[b];
        left[i] = std::abs(double(mesh.disparities[b]) - mesh.disparities[a] -
                           ((gradients[a].x + gradients[b].x) * (double(q.x) - p.x) +
                            (gradients[a].y + gradients[b].y) * (double(q.y) - p.y)) /
                               2);
    }
    return value_at_rank(left, left.size() / 2);
}

// Returns the means of all gradients and those at the other ends of sides that are alike.
std::vector<Gradient> means_of(const std::vector<Gradient>& gradients, const std::vector<Side>& sides,
                               double reach) {
    std::vector<Gradient> means = gradients;
    std::vector<double> weights(gradients.size(), 1.0);
    for (const auto& [a, b, length2] : sides) {
        const Gradient &g = gradients[a], &h = gradients[b];
        const double x = h.x - g.x, y = h.y - g.y;
        if ((x * x + y * y) * length2 > reach * reach) continue;
        means[a] = {means[a].x + h.x / 2, means[a].y + h.y / 2};
        means[b] = {means[b].x + g.x / 2, means[b].y + g.y / 2};
        weights[a] += 0.5;
        weights[b] += 0.5;
    }
    for (std::size_t i = 0; i < means.size(); ++i)
        means[i] = {means[i].x / weights[i], means[i].y / weights[i]};
    return means;
}

// Returns the medians, of either coordinate, of each gradient and those at the other ends of its sides: what
// mismatches turn far off is replaced, where means would leave it alone or spread it.
std::vector<Gradient> medians_of(const std::vector<Gradient>& gradients, const std::vector<Side>& sides) {
    const std::size_t count = gradients.size();
    // The two sides of an inner edge run in opposite directions, so the numbers around an inner vertex
    // cancel.
    std::vector<std::int64_t> balance(count, 0);
    for (const Side& side : sides) {
        balance[side.a] += side.b;
        balance[side.b] -= side.a;
    }
    // Border vertices get inner edges' other ends, and themselves, twice, so that border edges weigh half.
    const auto is_inner = [&](std::size_t v) { return balance[v] == 0; };
    std::vector<std::size_t> ends(count + 1, 0);  // of each vertex's values, after they are filled in
    for (const auto& [a, b, length2] : sides) {
        ++ends[a + 1];
        if (!is_inner(b)) ++ends[b + 1];
    }
    for (std::size_t i = 0; i < count; ++i) ends[i + 1] += ends[i] + (is_inner(i) ? 1 : 2);
    std::vector<double> x(ends[count]), y(ends[count]);
    const auto add = [&](std::size_t v, const Gradient& g) {
        x[ends[v]] = g.x;
        y[ends[v]++] = g.y;
    };
    for (std::size_t i = 0; i < count; ++i)
        for (int k = is_inner(i) ? 1 : 0; k < 2; ++k) add(i, gradients[i]);
    for (const auto& [a, b, length2] : sides) {
        add(a, gradients[b]);
        if (!is_inner(b)) add(b, gradients[a]);
    }
    std::vector<Gradient> medians(count);
    for (std::size_t i = 0, begin = 0; i < count; begin = ends[i++]) {
        const std::size_t size = ends[i] - begin;
        const auto median = [&](std::vector<double>& values) {
            const auto from = values.begin() + begin;
            std::sort(from, from + size);
            return (from[(size - 1) / 2] + from[size / 2]) / 2;
        };
        medians[i] = {median(x), median(y)};
    }
    return medians;
}

}  // namespace

std::array<double, 3> position_in_space(double x_px, double y_px, double disparity, const Calibration& c) {
    const double z = c.focal_px * c.baseline_m / (disparity + c.doffs_px);
    return {(x_px - c.cx) * z / c.focal_px, -(y_px - c.cy) * z / c.focal_px, -z};
}

SurfaceMesh build_surface(const DisparityMesh& cut_mesh, int width, int height,
                          const Calibration& calibration, int min_component,
                          std::vector<std::uint32_t>* sources) {
    check(cut_mesh, calibration);
    SurfaceMesh surface;
    surface.metric = calibration.metric;
    const std::vector<Vec3d> placed = placed_vertices(cut_mesh, calibration);
    surface.triangles = kept_triangles(cut_mesh, placed);
    // Fans are split before components are counted: parts that only touch in a
    // vertex are separate components.
    std::vector<std::uint32_t> source_vertices(cut_mesh.points.size());
    if (cut_mesh.has_one_fan_per_vertex && surface.triangles.size() == cut_mesh.triangles.size())
        std::iota(source_vertices.begin(), source_vertices.end(), 0u);
    else
        source_vertices = split_fans(surface.triangles, cut_mesh.points.size());
    if (min_component > 1) {
        drop_small_components(surface.triangles, source_vertices.size(), min_component);
        // Only renumbers: dropping whole components leaves no new touching fans.
        std::vector<std::uint32_t> kept = split_fans(surface.triangles, source_vertices.size());
        for (std::uint32_t& k : kept) k = source_vertices[k];
        source_vertices.swap(kept);
    }
    if (surface.triangles.empty())
        throw Error(
            ErrorKind::input,
            "surface: no triangle is left; lower density.background.fraction, surface.min_component or "
            "mesh.spacing_px");
    const std::size_t count = source_vertices.size();
    std::vector<Vec3d> positions(count);
    for (std::size_t i = 0; i < count; ++i) positions[i] = placed[source_vertices[i]];
    const std::vector<Vec3d> normals = normal_sums(surface.triangles, positions);
    surface.positions.resize(count);
    surface.normals.resize(count);
    surface.texcoords.resize(count);
    surface.image_points.resize(count);
    surface.disparities.resize(count);
    const float columns = static_cast<float>(width), rows = static_cast<float>(height);
    for (std::size_t i = 0; i < count; ++i) surface.image_points[i] = cut_mesh.points[source_vertices[i]];
    const std::vector<Vec2f> drawn = drawn_points(surface.triangles, positions, surface.image_points);
    for (std::size_t i = 0; i < count; ++i) {
        const Vec2f& p = drawn[i];
        const Vec3d& v = positions[i];
        surface.positions[i] = {float(v.x), float(v.y), float(v.z)};
        surface.normals[i] = unit_normal(normals[i], v);
        surface.texcoords[i] = {std::clamp(p.x / columns, 0.0f, 1.0f), std::clamp(p.y / rows, 0.0f, 1.0f)};
        surface.disparities[i] = cut_mesh.disparities[source_vertices[i]];
    }
    if (sources) *sources = std::move(source_vertices);
    return surface;
}

void smooth_normals(SurfaceMesh& mesh, const Calibration& camera, double quantum_px) {
    const std::size_t count = mesh.positions.size();
    std::vector<Gradient> gradients(count);
    for (std::size_t i = 0; i < count; ++i)
        gradients[i] = gradient_of(mesh.normals[i], mesh.positions[i], camera.baseline_m);
    std::vector<Side> sides;
    sides.reserve(3 * mesh.triangles.size());
    for (const Triangle& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = t[k], b = t[(k + 1) % 3];
            const double x = double(mesh.image_points[b].x) - mesh.image_points[a].x,
                         y = double(mesh.image_points[b].y) - mesh.image_points[a].y;
            sides.push_back({a, b, x * x + y * y});
        }
    if (sides.empty()) return;
    const bool has_steps = quantum_px > 0;
    const double reach = has_steps ? kOfQuantum * quantum_px : kOfNoise * noise_of(mesh, sides, gradients);
    if (!has_steps) gradients = medians_of(gradients, sides);
    for (int round = 0; round < (has_steps ? kRoundsOfQuantum : kRounds); ++round)
        gradients = means_of(gradients, sides, reach);
    if (!has_steps) gradients = medians_of(gradients, sides);
    for (std::size_t i = 0; i < count; ++i)
        mesh.normals[i] = normal_of(gradients[i], mesh.image_points[i], mesh.disparities[i], camera);
}

}  // namespace hexrelief::stages
