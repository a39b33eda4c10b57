#include "cuda/surface/fit/fit_silhouettes.h"

#include "cuda/common/grid.cuh"
#include "cuda/surface/fit/silhouette_warp.cuh"

namespace hexrelief::cuda {
namespace {

// Moves s.lattice.points and marks s.lattice.changed; reads s.pixels, s.labels.kept and s.labels.open.
// words: filled by FlagWords.
__device__ void fit_silhouettes(const CooperativeGrid& grid, const SurfaceState& s,
                                const SilhouetteFitArrays& a, uint4* words) {
    extern __shared__ float4 silhouette_scratch[];
    const unsigned points = s.counts->points, triangles = s.counts->triangles;
    // saves a barrier, and lists a few corners more
    const bool all = triangles <= grid.threads();
    SilhouetteLists<unsigned> corners = corner_lists(a);
    const auto put = [&] {
        put_corners(grid, a, corners, s.lattice.triangles, triangles,
                    [&](unsigned v) { return all || a.end_counts[v] > 0; });
    };
    if (all) put();
    const SilhouetteLists<SilhouetteEnd> ends =
        list_ends(grid, s, a, [&](unsigned v) { SilhouetteWarp::clear(a, v); });
    const unsigned count = a.totals->vertices;
    if (!all && count > 0) {
        put();
        grid.wait();
    }
    if (a.totals->corners_full) corners.pack(grid, points, put);
    // A warp keeps its vertices from the first round to the last. They are far apart, because neighbours are
    // alike, and vertices with long edges would keep one warp busy for long. In rows of four, cones at
    // 1800x1500 took 12 % longer.
    const unsigned warps = grid.warps();
    const bool keeps = count <= SilhouetteWarp::kVertices * warps;
    SilhouetteWarp warp(s, a, words, ends, corners,
                        reinterpret_cast<SilhouetteScratch*>(silhouette_scratch)[threadIdx.x / 32]);
    HEXRELIEF_ROLLED
    for (int half = 0; half < 2 * step::kSilhouetteRounds; ++half) {
        const int round = half / 2;
        const bool after = half % 2 == 1, fresh = half == 0 || !keeps;
        HEXRELIEF_ROLLED
        for (unsigned v = grid.warp(); v < count; v += SilhouetteWarp::kVertices * warps) {
            if (fresh)
                warp.begin(v, warps, min(SilhouetteWarp::kVertices, (count - v + warps - 1) / warps), round,
                           after);
            if (after)
                warp.move(round);
            else
                warp.find_targets(round, fresh);
        }
    }
    grid.wait();
    for (unsigned i = grid.thread(); i < (all ? points : count); i += grid.threads()) {
        const unsigned v = all ? i : a.vertices[i];
        a.end_counts[v] = a.corner_counts[v] = 0;
    }
    if (grid.thread() == 0) *a.totals = {};
}

__global__ void __launch_bounds__(kGridThreads, 1)
    fit_silhouettes_kernel(const __grid_constant__ SurfaceState s,
                           const __grid_constant__ SilhouetteFitArrays a, uint4* words) {
    if (s.totals->missing_capacity > 0) return;
    CooperativeGrid grid(s.board);
    fit_silhouettes(grid, s, a, words);
}

__global__ void __launch_bounds__(kGridThreads, 1)
    inset_silhouettes_kernel(const __grid_constant__ SurfaceState s,
                             const __grid_constant__ step::InsetArrays a) {
    if (s.totals->missing_capacity > 0) return;
    CooperativeGrid grid(s.board);
    const step::FanView<const std::int32_t(*)[3], const std::uint8_t(*)[3]> fans{
        s.lattice.triangles, s.lattice.neighbours, s.labels.open, s.labels.kept};
    step::inset_silhouettes(grid, s.view(), s.pixels.map, s.config.silhouette_inset_px, fans,
                            s.mesh_triangles(), s.cut_mesh.points, a);
}

}  // namespace

bool can_fit_silhouettes() {
    int blocks = 0;
    const bool fits =
        cudaFuncSetAttribute(fit_silhouettes_kernel, cudaFuncAttributeMaxDynamicSharedMemorySize,
                             kSilhouetteSharedBytes) == cudaSuccess &&
        cudaOccupancyMaxActiveBlocksPerMultiprocessor(&blocks, fit_silhouettes_kernel, kGridThreads,
                                                      kSilhouetteSharedBytes) == cudaSuccess;
    if (!fits) cudaGetLastError();  // a refusal is not a failure
    return fits && blocks > 0;
}

void begin_silhouettes(const Launch& launch, const SurfaceState& s, const SilhouetteFitArrays& a) {
    check(cudaMemsetAsync(a.end_counts, 0, silhouette_count_bytes(s.sizes), launch.stream), "clearing");
}

void fit_silhouettes(const Launch& launch, const SurfaceState& s, const SilhouetteFitArrays& a,
                     uint4* words) {
    launch_cooperative(launch, fit_silhouettes_kernel, kSilhouetteSharedBytes, "fitting silhouettes", s, a,
                       words);
}

void inset_silhouettes(const Launch& launch, const SurfaceState& s, const step::InsetArrays& a) {
    launch_cooperative(launch, inset_silhouettes_kernel, 0, "insetting silhouettes", s, a);
}

}  // namespace hexrelief::cuda
