#include "pipeline/bench/rd_meshes.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "mesher/mesher.h"
#include "pipeline/stages/density.h"
#include "pipeline/stages/silhouettes.h"
#include "pipeline/stages/surface.h"

#ifdef HEXRELIEF_HAS_MESHOPTIMIZER
#include <meshoptimizer.h>
#endif

namespace hexrelief::bench::rd {
namespace {

// Returns pixels from 0 to size - 1, both included, about `spacing_px` apart.
std::vector<int> grid_lines(int size, double spacing_px) {
    const int steps = std::max(1, static_cast<int>(std::lround((size - 1) / spacing_px)));
    std::vector<int> lines;
    for (int i = 0; i <= steps; ++i)
        lines.push_back(static_cast<int>(std::lround(static_cast<double>(size - 1) * i / steps)));
    return lines;
}

// Returns the map with each unknown pixel at the farther one of its row's nearest known disparities (0 in a
// row without any), so that no grid spends bytes on the silhouettes of holes.
DisparityMap filled(DisparityMap map) {
    std::vector<float> before(map.width);
    for (int y = 0; y < map.height; ++y) {
        float last = 0;
        for (int x = 0; x < map.width; ++x) {
            if (DisparityMap::known(map.at(x, y)) && map.at(x, y) > 0) last = map.at(x, y);
            before[x] = last;
        }
        last = 0;
        for (int x = map.width - 1; x >= 0; --x) {
            if (DisparityMap::known(map.at(x, y)) && map.at(x, y) > 0)
                last = map.at(x, y);
            else
                map.at(x, y) =
                    before[x] > 0 && last > 0 ? std::min(before[x], last) : std::max(before[x], last);
        }
    }
    return map;
}

}  // namespace

SurfaceMesh with_used_vertices(const SurfaceMesh& mesh, const std::vector<Triangle>& triangles) {
    constexpr std::uint32_t kUnused = ~0u;
    std::vector<std::uint32_t> index(mesh.disparities.size(), kUnused);
    for (const Triangle& t : triangles)
        for (const std::uint32_t corner : t) index[corner] = 0;
    SurfaceMesh out;
    for (std::size_t i = 0; i < index.size(); ++i) {
        if (index[i] == kUnused) continue;
        index[i] = static_cast<std::uint32_t>(out.disparities.size());
        out.image_points.push_back(mesh.image_points[i]);
        out.disparities.push_back(mesh.disparities[i]);
    }
    for (const Triangle& t : triangles) out.triangles.push_back({index[t[0]], index[t[1]], index[t[2]]});
    return out;
}

SurfaceMesh preset_mesh(const DisparityMap& map, const config::Config& config, int threads) {
    const DensityMap density = stages::compute_density(map, config.density);
    const HexMesh2D lattice = mesher::solve_mesh(density, config.mesh, threads, {});
    // Any camera will do, because errors are measured in the image.
    const Calibration camera{double(map.width), 0.5 * map.width, 0.5 * map.height, 1, 0, false, 0, 0};
    DisparityMesh cut_mesh = surface::cut_disparity_mesh({&lattice, &map, density.background_px, nullptr},
                                                         config.surface, threads);
    stages::adjust_silhouettes(cut_mesh, map, density.background_px, config.surface.silhouette_rounds);
    return stages::build_surface(cut_mesh, map.width, map.height, camera, config.surface.min_component);
}

SurfaceMesh uniform_mesh(const DisparityMap& given, float background_px, double spacing_px) {
    const DisparityMap map = filled(given);
    const std::vector<int> columns = grid_lines(map.width, spacing_px),
                           rows = grid_lines(map.height, spacing_px);
    SurfaceMesh mesh;
    std::vector<char> kept;
    for (const int y : rows)
        for (const int x : columns) {
            const float d = map.at(x, y);
            kept.push_back(d > 0 && d >= background_px);
            mesh.image_points.push_back({x + 0.5f, y + 0.5f});
            mesh.disparities.push_back(d);
        }
    std::vector<Triangle> triangles;
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        if (kept[a] || kept[b] || kept[c]) triangles.push_back({a, b, c});
    };
    const auto width = static_cast<std::uint32_t>(columns.size());
    for (std::uint32_t row = 0; row + 1 < rows.size(); ++row)
        for (std::uint32_t column = 0; column + 1 < width; ++column) {
            const std::uint32_t a = row * width + column, b = a + 1, c = a + width, d = c + 1;
            add(a, c, b);
            add(b, c, d);
        }
    return with_used_vertices(mesh, triangles);
}

SurfaceMesh without_steps(SurfaceMesh full, double step_px) {
    std::vector<Triangle> triangles;
    for (const Triangle& t : full.triangles) {
        const float a = full.disparities[t[0]], b = full.disparities[t[1]], c = full.disparities[t[2]];
        if (std::max({a, b, c}) - std::min({a, b, c}) <= step_px) triangles.push_back(t);
    }
    return with_used_vertices(full, triangles);
}

#ifdef HEXRELIEF_HAS_MESHOPTIMIZER

bool has_simplification() {
    return true;
}

SurfaceMesh simplified_mesh(const SurfaceMesh& full, std::size_t triangles) {
    constexpr float kAnyError = 1e9f;  // only the number of triangles decides
    std::vector<float> points;
    points.reserve(3 * full.disparities.size());
    for (std::size_t i = 0; i < full.disparities.size(); ++i)
        points.insert(points.end(), {full.image_points[i].x, full.image_points[i].y, full.disparities[i]});
    std::vector<unsigned> from, to(3 * full.triangles.size());
    from.reserve(to.size());
    for (const Triangle& t : full.triangles) from.insert(from.end(), t.begin(), t.end());
    to.resize(meshopt_simplify(to.data(), from.data(), from.size(), points.data(), full.disparities.size(),
                               3 * sizeof(float), 3 * triangles, kAnyError, 0, nullptr));
    std::vector<Triangle> left;
    for (std::size_t i = 0; i + 2 < to.size(); i += 3) left.push_back({to[i], to[i + 1], to[i + 2]});
    return with_used_vertices(full, left);
}

#else

bool has_simplification() {
    return false;
}

SurfaceMesh simplified_mesh(const SurfaceMesh&, std::size_t) {
    throw std::logic_error("built without meshoptimizer");
}

#endif

}  // namespace hexrelief::bench::rd
