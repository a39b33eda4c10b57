#include "mesher/surface/fit/inset_silhouettes.h"

#include <algorithm>

#include "mesher/surface/fit/inset_silhouettes_step.h"
#include "mesher/surface/topology/triangle_shape_step.h"
#include "pipeline/data/counting_sort.h"

namespace hexrelief::surface {
namespace {

// The positions of a triangle's corners.
struct Corners {
    Vec2f at[3];
};

Corners corners_of(const std::vector<Vec2f>& points, const Triangle& t) {
    return {{points[t[0]], points[t[1]], points[t[2]]}};
}

}  // namespace

void inset_silhouettes(const PixelSurfaces& surfaces, const DisparityMap& map, double by_px,
                       const LatticeFans& fans, CutTriangles& cut, ThreadPool& pool) {
    const std::vector<Triangle>& triangles = cut.triangles;
    std::vector<Vec2f>& points = cut.points;
    const step::PixelView view = surfaces.view();
    const float width = static_cast<float>(view.width), height = static_cast<float>(view.height);
    const Buckets around = sort_into(points.size(), [&](const auto& put) {
        for (std::uint32_t t = 0; t < triangles.size(); ++t)
            for (std::uint32_t k = 0; k < 3; ++k) put(triangles[t][k], 3 * t + k);
    });
    std::vector<Vec2f> targets(points.size());
    pool.parallel_for_chunks(points.size(), [&](std::size_t first, std::size_t last) {
        for (std::size_t v = first; v < last; ++v) {
            targets[v] = points[v];
            if (!step::is_at_high_steps(view, map.values.data(), points[v])) continue;
            step::Inwards inwards;
            for (const std::uint32_t corner : around[v])
                step::add_inwards(inwards, corners_of(points, triangles[corner / 3]).at,
                                  static_cast<int>(corner % 3));
            targets[v] = step::inset_point(points[v], inwards, by_px, width, height);
        }
    });
    std::vector<Vec2f> moved(points.size());
    pool.parallel_for_chunks(points.size(), [&](std::size_t first, std::size_t last) {
        for (std::size_t v = first; v < last; ++v) {
            const auto is_free = [&](std::uint32_t corner) {
                const step::Corner own{cut.source_triangles[corner / 3], corner % 3};
                const Corners from = corners_of(points, triangles[corner / 3]),
                              to = corners_of(targets, triangles[corner / 3]);
                return (step::free_corners(from.at, to.at, step::kInsetLeastShape) >> own.k & 1) != 0 &&
                       !step::uncovers_surface(view, fans, own, from.at, to.at);
            };
            const auto corners = around[v];
            const bool moves =
                targets[v] != points[v] && std::all_of(corners.begin(), corners.end(), is_free);
            moved[v] = moves ? targets[v] : points[v];
        }
    });
    points = std::move(moved);
}

}  // namespace hexrelief::surface
