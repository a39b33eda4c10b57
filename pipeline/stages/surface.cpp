#include "pipeline/stages/surface.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "pipeline/data/error.h"
#include "pipeline/stages/surface_topology.h"

namespace hexrelief {
namespace {

constexpr double kDegenerateArea_px = 1e-4;  // twice a triangle's area in the image
constexpr double kJumpShare = 0.04;          // of the spread of the foreground's disparities
constexpr double kJumpSlope = 0.5;           // disparity px per image px

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

bool foreground(float d, float background_px) {
    return DisparityMap::known(d) && d > 0 && d >= background_px;
}

Vec3d to_space(const Vec2f& p, double disparity, const Calibration& c) {
    const double z = c.focal_px * c.baseline_m / (disparity + c.doffs_px);
    return {(p.x - c.cx) * z / c.focal_px, -(p.y - c.cy) * z / c.focal_px, -z};
}

void check(const SurfaceInput& input, const Calibration& calibration) {
    const HexMesh2D& mesh = *input.mesh;
    const std::size_t count = static_cast<std::size_t>(mesh.columns) * mesh.rows;
    if (mesh.positions.size() != count || input.vertex_disparities->size() != count) {
        throw Error(ErrorKind::input, "surface: the mesh has " + std::to_string(count) +
                                          " lattice vertices, but " + std::to_string(mesh.positions.size()) +
                                          " positions and " +
                                          std::to_string(input.vertex_disparities->size()) + " disparities");
    }
    const DisparityMap& map = *input.map;
    if (map.width < 1 || map.height < 1 ||
        map.values.size() != static_cast<std::size_t>(map.width) * map.height) {
        throw Error(ErrorKind::input,
                    "surface: the disparity map is empty; give the map that the mesh was made from");
    }
    const auto positive = [](double value) { return std::isfinite(value) && value > 0; };
    if (!positive(calibration.focal_px))
        throw Error(ErrorKind::input, "calibration: focal_px must be above 0");
    if (!positive(calibration.baseline_m))
        throw Error(ErrorKind::input, "calibration: baseline_m must be above 0");
}

// Which lattice vertices can be placed in space at all.
std::vector<bool> usable_vertices(const SurfaceInput& input, const Calibration& calibration) {
    const std::vector<float>& disparities = *input.vertex_disparities;
    std::vector<bool> usable(disparities.size());
    for (std::size_t i = 0; i < disparities.size(); ++i) {
        const Vec2f& p = input.mesh->positions[i];
        if (!DisparityMap::known(disparities[i]) || !(disparities[i] + calibration.doffs_px > 0)) continue;
        const Vec3d v = to_space(p, disparities[i], calibration);
        const auto fits = [](double value) { return std::isfinite(static_cast<float>(value)); };
        usable[i] = fits(v.x) && fits(v.y) && fits(v.z);
    }
    return usable;
}

// The smallest difference that may be a depth edge, where the configuration leaves the choice.
double chosen_jump(const SurfaceInput& input) {
    std::vector<float> known;
    for (const float d : input.map->values) {
        if (foreground(d, input.background_px)) known.push_back(d);
    }
    if (known.empty()) return 1;
    const auto percentile = [&](std::size_t percent) {
        const auto nth = known.begin() + static_cast<std::ptrdiff_t>((known.size() - 1) * percent / 100);
        std::nth_element(known.begin(), nth, known.end());
        return static_cast<double>(*nth);
    };
    const double low = percentile(2);
    return std::max(1.0, kJumpShare * (percentile(98) - low));
}

class TriangleFilter {
  public:
    TriangleFilter(const SurfaceInput& input, const SurfaceConfig& config)
        : input_(input),
          given_(config.max_disparity_jump_px > 0),
          jump_(given_ ? config.max_disparity_jump_px : chosen_jump(input)) {}

    bool keeps(const Triangle& triangle) const {
        const Vec2f &a = point(triangle[0]), &b = point(triangle[1]), &c = point(triangle[2]);
        const double abx = double(b.x) - a.x, aby = double(b.y) - a.y, acx = double(c.x) - a.x,
                     acy = double(c.y) - a.y;
        const double area = abx * acy - aby * acx;
        if (!(area > kDegenerateArea_px)) return false;
        const double da = disparity(triangle[0]), db = disparity(triangle[1]), dc = disparity(triangle[2]);
        if (std::max({da, db, dc}) - std::min({da, db, dc}) > jump_) {
            const double gx = ((db - da) * acy - (dc - da) * aby) / area;
            const double gy = ((dc - da) * abx - (db - da) * acx) / area;
            if (given_ || std::sqrt(gx * gx + gy * gy) > kJumpSlope) return false;
        }
        const int empty = int(is_empty((double(a.x) + b.x + c.x) / 3, (double(a.y) + b.y + c.y) / 3)) +
                          int(is_empty((double(a.x) + b.x) / 2, (double(a.y) + b.y) / 2)) +
                          int(is_empty((double(b.x) + c.x) / 2, (double(b.y) + c.y) / 2)) +
                          int(is_empty((double(c.x) + a.x) / 2, (double(c.y) + a.y) / 2));
        return empty <= 2;
    }

  private:
    const Vec2f& point(std::uint32_t i) const { return input_.mesh->positions[i]; }
    double disparity(std::uint32_t i) const { return (*input_.vertex_disparities)[i]; }
    // Background or unknown at image point (x, y), in px.
    bool is_empty(double x, double y) const {
        const DisparityMap& map = *input_.map;
        const int column = std::clamp(static_cast<int>(std::floor(x)), 0, map.width - 1);
        const int row = std::clamp(static_cast<int>(std::floor(y)), 0, map.height - 1);
        return !foreground(map.at(column, row), input_.background_px);
    }

    const SurfaceInput& input_;
    bool given_;
    double jump_;
};

std::vector<Triangle> kept_triangles(const SurfaceInput& input, const Calibration& calibration,
                                     const SurfaceConfig& config) {
    const std::vector<bool> usable = usable_vertices(input, calibration);
    const TriangleFilter filter(input, config);
    const HexMesh2D& mesh = *input.mesh;
    std::vector<Triangle> triangles;
    for (int row = 0; row + 1 < mesh.rows; ++row) {
        for (int column = 0; column + 1 < mesh.columns; ++column) {
            for (const Triangle& t : quad_triangles(mesh.columns, column, row)) {
                if (!usable[t[0]] || !usable[t[1]] || !usable[t[2]] || !filter.keeps(t)) continue;
                // Positive area with y down is clockwise to the eye.
                triangles.push_back({t[0], t[2], t[1]});
            }
        }
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

SurfaceMesh build_surface(const SurfaceInput& input, const Calibration& calibration,
                          const SurfaceConfig& config) {
    check(input, calibration);
    SurfaceMesh surface;
    surface.metric = calibration.metric;
    surface.triangles = kept_triangles(input, calibration, config);
    // Fans are split before components are counted (a touching vertex does not hold parts together) and again
    // after, which only renumbers: dropping whole components leaves no new touching fans.
    std::vector<std::uint32_t> lattice = split_fans(surface.triangles, input.mesh->positions.size());
    drop_small_components(surface.triangles, lattice.size(), config.min_component);
    if (surface.triangles.empty()) {
        throw Error(ErrorKind::input,
                    "surface: no triangle is left; lower density.background, surface.min_component or "
                    "mesh.spacing_px");
    }
    const std::vector<std::uint32_t> kept = split_fans(surface.triangles, lattice.size());

    std::vector<Vec3d> positions;
    positions.reserve(kept.size());
    for (const std::uint32_t k : kept) {
        const std::uint32_t i = lattice[k];
        const Vec2f& p = input.mesh->positions[i];
        const float d = (*input.vertex_disparities)[i];
        const Vec3d v = to_space(p, d, calibration);
        positions.push_back(v);
        surface.positions.push_back({float(v.x), float(v.y), float(v.z)});
        surface.texcoords.push_back({std::clamp(p.x / input.map->width, 0.0f, 1.0f),
                                     std::clamp(p.y / input.map->height, 0.0f, 1.0f)});
        surface.image_points.push_back(p);
        surface.disparities.push_back(d);
    }
    compute_normals(surface, positions);
    count_topology(surface);
    return surface;
}

}  // namespace hexrelief
