#include "pipeline/stages/surface.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "pipeline/data/error.h"
#include "pipeline/stages/surface_topology.h"

namespace hexrelief {
namespace {

constexpr double kDegenerateArea_px = 1e-4;  // twice a triangle's area in the image

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

Vec3d to_space(const Vec2f& p, double disparity, const Calibration& c) {
    const double z = c.focal_px * c.baseline_m / (disparity + c.doffs_px);
    return {(p.x - c.cx) * z / c.focal_px, -(p.y - c.cy) * z / c.focal_px, -z};
}

void check(const SheetMesh& sheet, const Calibration& calibration) {
    if (sheet.points.size() != sheet.disparities.size())
        throw Error(ErrorKind::input, "surface: the sheet has " + std::to_string(sheet.points.size()) +
                                          " vertices, but " + std::to_string(sheet.disparities.size()) +
                                          " disparities");
    const auto positive = [](double value) { return std::isfinite(value) && value > 0; };
    if (!positive(calibration.focal_px))
        throw Error(ErrorKind::input, "calibration: focal_px must be above 0");
    if (!positive(calibration.baseline_m))
        throw Error(ErrorKind::input, "calibration: baseline_m must be above 0");
}

// Which vertices can be placed in space at all.
std::vector<bool> usable_vertices(const SheetMesh& sheet, const Calibration& calibration) {
    std::vector<bool> usable(sheet.points.size());
    for (std::size_t i = 0; i < usable.size(); ++i) {
        const float d = sheet.disparities[i];
        if (!std::isfinite(d) || !(d + calibration.doffs_px > 0)) continue;
        const Vec3d v = to_space(sheet.points[i], d, calibration);
        const auto fits = [](double value) { return std::isfinite(static_cast<float>(value)); };
        usable[i] = fits(v.x) && fits(v.y) && fits(v.z);
    }
    return usable;
}

std::vector<Triangle> kept_triangles(const SheetMesh& sheet, const Calibration& calibration) {
    const std::vector<bool> usable = usable_vertices(sheet, calibration);
    std::vector<Triangle> triangles;
    for (const Triangle& t : sheet.triangles) {
        if (!usable[t[0]] || !usable[t[1]] || !usable[t[2]]) continue;
        const Vec2f &a = sheet.points[t[0]], &b = sheet.points[t[1]], &c = sheet.points[t[2]];
        const double area =
            (double(b.x) - a.x) * (double(c.y) - a.y) - (double(b.y) - a.y) * (double(c.x) - a.x);
        // Positive area with y down is clockwise to the eye.
        if (area > kDegenerateArea_px) triangles.push_back({t[0], t[2], t[1]});
    }
    return triangles;
}

// Weighted by the angle at the vertex: by area, the few long triangles on steep flanks would outweigh all
// others.
void compute_normals(SurfaceMesh& surface, const std::vector<Vec3d>& positions) {
    std::vector<Vec3d> sums(positions.size());
    for (const Triangle& t : surface.triangles) {
        const Vec3d normal = cross(positions[t[1]] - positions[t[0]], positions[t[2]] - positions[t[0]]);
        const double twice_area = length(normal);
        if (!(twice_area > 0)) continue;
        for (int k = 0; k < 3; ++k) {
            const Vec3d u = positions[t[(k + 1) % 3]] - positions[t[k]],
                        v = positions[t[(k + 2) % 3]] - positions[t[k]];
            const double weight = std::atan2(twice_area, dot(u, v)) / twice_area;
            Vec3d& sum = sums[t[k]];
            sum = {sum.x + weight * normal.x, sum.y + weight * normal.y, sum.z + weight * normal.z};
        }
    }
    surface.normals.reserve(sums.size());
    for (std::size_t i = 0; i < sums.size(); ++i) {
        // Every face looks at the camera, hence so does the sum; only underflow can make it vanish.
        Vec3d n = sums[i];
        if (!(length(n) > 0)) n = {-positions[i].x, -positions[i].y, -positions[i].z};
        const double size = length(n);
        surface.normals.push_back({float(n.x / size), float(n.y / size), float(n.z / size)});
    }
}

}  // namespace

SurfaceMesh build_surface(const SheetMesh& sheet, int width, int height, const Calibration& calibration,
                          const SurfaceConfig& config) {
    check(sheet, calibration);
    SurfaceMesh surface;
    surface.metric = calibration.metric;
    surface.triangles = kept_triangles(sheet, calibration);
    // Fans are split before components are counted: a touching vertex does not hold parts together.
    std::vector<std::uint32_t> origins = split_fans(surface.triangles, sheet.points.size());
    if (config.min_component > 1) {
        drop_small_components(surface.triangles, origins.size(), config.min_component);
        // only renumbers: dropping whole components leaves no new touching fans
        std::vector<std::uint32_t> kept = split_fans(surface.triangles, origins.size());
        for (std::uint32_t& k : kept) k = origins[k];
        origins.swap(kept);
    }
    if (surface.triangles.empty()) {
        throw Error(ErrorKind::input,
                    "surface: no triangle is left; lower density.background, surface.min_component or "
                    "mesh.spacing_px");
    }
    std::vector<Vec3d> positions;
    positions.reserve(origins.size());
    for (const std::uint32_t i : origins) {
        const Vec2f& p = sheet.points[i];
        const float d = sheet.disparities[i];
        const Vec3d v = to_space(p, d, calibration);
        positions.push_back(v);
        surface.positions.push_back({float(v.x), float(v.y), float(v.z)});
        surface.texcoords.push_back({std::clamp(p.x / static_cast<float>(width), 0.0f, 1.0f),
                                     std::clamp(p.y / static_cast<float>(height), 0.0f, 1.0f)});
        surface.image_points.push_back(p);
        surface.disparities.push_back(d);
    }
    compute_normals(surface, positions);
    return surface;
}

}  // namespace hexrelief
