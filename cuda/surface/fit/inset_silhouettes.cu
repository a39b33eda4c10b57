#include "cuda/surface/fit/inset_silhouettes.h"

#include "cuda/common/grid.cuh"
#include "cuda/surface/fit/silhouette_lists.cuh"
#include "mesher/surface/fit/inset_silhouettes_step.h"
#include "mesher/surface/topology/triangle_shape_step.h"

namespace hexrelief::cuda {
namespace {

// True if a vertex may move. Eight threads share the vertex's `corner_count` corners; all lanes of a warp
// call it, for four vertices.
__device__ bool is_free(const SurfaceState& s, const unsigned* corners, unsigned corner_count,
                        const Vec2f* targets) {
    const unsigned lane = threadIdx.x % 32;
    const Vec2f* const points = s.cut_mesh.points;
    const step::FanView<const std::int32_t(*)[3], const std::uint8_t(*)[3]> fans{
        s.lattice.triangles, s.lattice.neighbours, s.labels.open, s.labels.kept};
    bool free = true;
    for (unsigned c = lane % 8; c < corner_count; c += 8) {
        const unsigned number = corners[c] / 3, k = corners[c] % 3;
        const Triangle& t = s.cut_mesh.triangles[number];
        const step::Corner own{s.cut_mesh.source_triangles[number], k};
        const Vec2f from[3] = {points[t[0]], points[t[1]], points[t[2]]};
        const Vec2f to[3] = {targets[t[0]], targets[t[1]], targets[t[2]]};
        free = free && (step::free_corners(from, to, step::kInsetLeastShape) >> k & 1) &&
               !step::uncovers_surface(s.view(), fans, own, from, to);
    }
    return (__ballot_sync(~0u, free) >> (lane & 24) & 0xff) == 0xff;
}

// Moves s.cut_mesh.points; reads the rest of s.cut_mesh and s.pixels. It uses the arrays of the silhouettes'
// fit, which are large enough for mesh_points and mesh_triangles.
__device__ void inset_silhouettes(const CooperativeGrid& grid, const SurfaceState& s,
                                  const SilhouetteFitArrays& a) {
    const unsigned points = s.totals->mesh_points;
    const step::PixelView view = s.view();
    const float width = static_cast<float>(view.width), height = static_cast<float>(view.height);
    Vec2f* const targets = a.points;
    for (unsigned start = grid.thread() - grid.lane(); start < points; start += grid.threads()) {
        const unsigned v = start + grid.lane();
        bool moves = false;
        if (v < points) {
            moves = step::is_at_high_steps(view, s.pixels.map, s.cut_mesh.points[v]);
            a.moved[v] = moves;
            targets[v] = s.cut_mesh.points[v];
        }
        const unsigned at = claim(&a.totals->vertices, moves);
        if (moves) a.vertices[at] = v;
    }
    grid.wait();
    const unsigned vertices = a.totals->vertices;
    SilhouetteLists<unsigned> corners = corner_lists(a);
    const auto put = [&] {
        put_corners(grid, a, corners, s.cut_mesh.triangles, s.totals->mesh_triangles,
                    [&](unsigned v) { return a.moved[v] != 0; });
    };
    put();
    grid.wait();
    if (a.totals->corners_full) corners.pack(grid, points, put);
    grid.each(vertices, [&](unsigned i) {
        const unsigned v = a.vertices[i];
        step::Inwards inwards;
        in_order(
            a.corners + corners.first(v), a.corner_counts[v], [](unsigned corner) { return corner; },
            [&](unsigned corner) {
                const Triangle& t = s.cut_mesh.triangles[corner / 3];
                const Vec2f at[3] = {s.cut_mesh.points[t[0]], s.cut_mesh.points[t[1]],
                                     s.cut_mesh.points[t[2]]};
                step::add_inwards(inwards, at, static_cast<int>(corner % 3));
            });
        targets[v] =
            step::inset_point(s.cut_mesh.points[v], inwards, s.config.silhouette_inset_px, width, height);
    });
    for (unsigned start = grid.warp() * 4; start < vertices; start += grid.warps() * 4) {
        const unsigned i = start + grid.lane() / 8;
        const unsigned v = i < vertices ? a.vertices[i] : 0;
        const bool moves =
            is_free(s, a.corners + corners.first(v), i < vertices ? a.corner_counts[v] : 0, targets);
        if (i < vertices && grid.lane() % 8 == 0) a.moved[v] = moves ? 2 : 1;
    }
    grid.wait();
    grid.each(vertices, [&](unsigned i) {
        const unsigned v = a.vertices[i];
        if (a.moved[v] == 2) s.cut_mesh.points[v] = targets[v];
    });
}

__global__ void __launch_bounds__(kGridThreads, 1)
    inset_silhouettes_kernel(const __grid_constant__ SurfaceState s,
                             const __grid_constant__ SilhouetteFitArrays a) {
    if (s.totals->missing_capacity > 0) return;
    CooperativeGrid grid(s.board);
    inset_silhouettes(grid, s, a);
}

}  // namespace

void inset_silhouettes(const Launch& launch, const SurfaceState& s, const SilhouetteFitArrays& a) {
    launch_cooperative(launch, inset_silhouettes_kernel, 0, "insetting silhouettes", s, a);
}

}  // namespace hexrelief::cuda
