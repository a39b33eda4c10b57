#include "pipeline/stages/smooth_normals.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace hexrelief::stages {
namespace {

// How far means reach: gradients at the ends of an edge may differ by so many times the noise, or the
// quantum, over the edge.
constexpr double kOfNoise = 5, kOfQuantum = 0.25;
constexpr int kRounds = 8, kRoundsOfQuantum = 4;

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
    const auto middle = left.begin() + static_cast<std::ptrdiff_t>(left.size() / 2);
    std::nth_element(left.begin(), middle, left.end());
    return *middle;
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

}  // namespace

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
    const double reach =
        quantum_px > 0 ? kOfQuantum * quantum_px : kOfNoise * noise_of(mesh, sides, gradients);
    const int rounds = quantum_px > 0 ? kRoundsOfQuantum : kRounds;
    for (int round = 0; round < rounds; ++round) gradients = means_of(gradients, sides, reach);
    for (std::size_t i = 0; i < count; ++i)
        mesh.normals[i] = normal_of(gradients[i], mesh.image_points[i], mesh.disparities[i], camera);
}

}  // namespace hexrelief::stages
