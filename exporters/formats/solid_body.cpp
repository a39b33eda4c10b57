#include "exporters/formats/solid_body.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace hexrelief::exporters {
namespace {

constexpr double kFarthestShare = 0.001;  // of the vertices, which noise may have put anywhere
constexpr double kMostOfDepth = 0.5;      // that the base may be thick

double depth_of(const Vec3f& p) {
    return -static_cast<double>(p.z);
}

double farthest(const std::vector<Vec3f>& positions) {
    std::vector<double> depths;
    for (const Vec3f& p : positions) depths.push_back(depth_of(p));
    const auto at =
        static_cast<std::ptrdiff_t>((1 - kFarthestShare) * static_cast<double>(depths.size() - 1));
    std::nth_element(depths.begin(), depths.begin() + at, depths.end());
    return depths[static_cast<std::size_t>(at)];
}

// Returns the larger side of what all rays cover at a depth of 1.
double extent(const std::vector<Vec3f>& positions) {
    double low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL};
    for (const Vec3f& p : positions)
        for (int k = 0; k < 2; ++k) {
            const double at = (k == 0 ? p.x : p.y) / depth_of(p);
            low[k] = std::min(low[k], at);
            high[k] = std::max(high[k], at);
        }
    return std::max(high[0] - low[0], high[1] - low[1]);
}

// Returns the sides of triangles that no neighbour shares, as (from, to) of their triangle, in order.
std::vector<std::pair<std::uint32_t, std::uint32_t>> border_of(const std::vector<Triangle>& triangles) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> sides, border;
    for (const Triangle& t : triangles)
        for (std::size_t k = 0; k < 3; ++k) sides.emplace_back(t[k], t[(k + 1) % 3]);
    std::sort(sides.begin(), sides.end());
    for (const auto& [from, to] : sides)
        if (!std::binary_search(sides.begin(), sides.end(), std::pair(to, from)))
            border.emplace_back(from, to);
    return border;
}

}  // namespace

SurfaceMesh solid_body(const SurfaceMesh& surface, double size_mm) {
    SurfaceMesh body;
    body.triangles.assign(surface.triangles.begin(),
                          surface.triangles.begin() + static_cast<std::ptrdiff_t>(surface.left_triangles()));
    body.positions.assign(surface.positions.begin(),
                          surface.positions.begin() + static_cast<std::ptrdiff_t>(surface.left_vertices()));
    const std::size_t count = body.positions.size();
    const double far = farthest(body.positions), wide = extent(body.positions);
    const double thickness_mm = std::min(kLeastThickness_mm, size_mm / 20);
    // At the base one metre of depth is `scale` mm; the base is as far behind `far` as is thick enough.
    const double base = far / (1 - std::min(kMostOfDepth, thickness_mm * wide / size_mm));
    const double scale = size_mm / (wide * base);
    body.positions.resize(2 * count);
    for (std::size_t i = 0; i < count; ++i) {
        const Vec3f p = body.positions[i];
        const auto at_depth = [&](double depth) {
            return Vec3f{static_cast<float>(p.x / depth_of(p) * depth * scale),
                         static_cast<float>(p.y / depth_of(p) * depth * scale),
                         static_cast<float>((base - depth) * scale)};
        };
        body.positions[i] = at_depth(std::min(depth_of(p), far));
        body.positions[count + i] = at_depth(base);
    }
    const auto below = [&](std::uint32_t vertex) { return vertex + static_cast<std::uint32_t>(count); };
    const std::vector<Triangle> front = body.triangles;
    for (const Triangle& t : front) body.triangles.push_back({below(t[0]), below(t[2]), below(t[1])});
    for (const auto& [from, to] : border_of(front)) {
        body.triangles.push_back({to, from, below(from)});
        body.triangles.push_back({to, below(from), below(to)});
    }
    return body;
}

}  // namespace hexrelief::exporters
