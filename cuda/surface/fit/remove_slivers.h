// Takes slivers from the mesh.
#pragma once

#include <cstdint>

#include "cuda/common/arena.h"
#include "cuda/common/launch.h"
#include "cuda/common/surface_state.h"

namespace hexrelief::cuda {

struct SliverArrays {
    std::uint8_t *slivers, *used;  // of triangles; of vertices
    unsigned* indices;             // of vertices, and of the first triangle behind them
    Vec2f* points;                 // as they will be,
    float* disparities;
    Triangle* triangles;  // in the same row as the vertices
};

inline SliverArrays take_sliver_arrays(const SurfaceSizes& sizes, Arena& arena) {
    const std::size_t points = sizes.most_points, triangles = sizes.most_triangles;
    SliverArrays a{};
    a.slivers = arena.take<std::uint8_t>(triangles);
    a.used = arena.take<std::uint8_t>(points);
    a.indices = arena.take<unsigned>(points + 1);
    a.points = arena.take<Vec2f>(points);
    a.disparities = arena.take<float>(points);
    a.triangles = arena.take<Triangle>(points + triangles);
    return a;
}

// As hexrelief::remove_slivers(): where the mesh is cut and not bridged, after fit_disparities(); takes the
// slivers from s.cut_mesh and from the totals.
void remove_slivers(const Launch& launch, const SurfaceState& s, const SliverArrays& a);

}  // namespace hexrelief::cuda
