#include "cuda/surface/topology/split_triangles.h"

#include "cuda/common/grid.cuh"
#include "cuda/surface/pixels/crack_query.cuh"

namespace hexrelief::cuda {
namespace {

// Finds the places by groups of lanes; the rest is the CPU's code.
class DeviceSplitter {
  public:
    __device__ DeviceSplitter(const SurfaceState& s, const SplitArrays& a, unsigned lane)
        : s_(s),
          numbers_(a.numbers),
          query_(WarpQuery::of(s, a.silhouettes, lane)),
          splitter_({s.lattice.points, s.lattice.triangles, s.lattice.neighbours, s.lattice.changed}, a) {}

    __device__ void split_at_silhouettes(CooperativeGrid& grid) const {
        const int columns = s_.sizes.columns, rows = s_.sizes.rows;
        const step::LatticeCounts counts{
            s_.sizes.vertices(), step::number_slots(grid, columns, rows, s_.lattice.points, numbers_)};
        if (counts.triangles > s_.sizes.most_triangles)
            return miss(grid, counts.triangles - s_.sizes.most_triangles);
        if (grid.is_first()) *s_.counts = {counts.points, counts.triangles, 0, 0};
        step::write_slots(grid, columns, rows, numbers_, splitter_.lattice());
        splitter_.clear_shares(grid, counts.triangles);
        const std::uint8_t* const on_silhouette = s_.lattice.on_silhouette;
        bool found = false;
        each_owned_edge<16>(
            grid, counts.triangles,
            [&](std::int32_t t, int k) {
                const auto [a, b, p, q] = splitter_.edge(t, k);
                return !(on_silhouette[a] && on_silhouette[b]) && step::may_cross(s_.tiles(), p, q);
            },
            [&](std::int32_t t, int k, const LaneGroup& group) {
                const auto [a, b, p, q] = splitter_.edge(t, k);
                const float share =
                    step::open_crossing(query_.part(group), p, on_silhouette[a], q, on_silhouette[b], true);
                if (query_.lane == group.first) found |= splitter_.put_share(t, k, share);
            });
        if (grid.any(found)) split(grid, counts);
    }
    __device__ void split_straddling(CooperativeGrid& grid) const {
        const step::LatticeCounts counts{s_.counts->points, s_.counts->triangles};
        const std::uint8_t* const straddling = s_.labels.straddling;
        bool found = false;
        each_owned_edge<32>(
            grid, counts.triangles,
            [&](std::int32_t t, int k) {
                const std::int32_t n = s_.lattice.neighbours[t][k];
                return straddling[t] || (n >= 0 && straddling[n]);
            },
            [&](std::int32_t t, int k, const LaneGroup& group) {
                const step::SplitEdge e = splitter_.edge(t, k);
                const unsigned forth = (query_.lane - group.first) / (group.size / 2);
                const float own =
                    step::crossing_from_middle(query_.part(group.half(forth)), e.p, e.q, !forth);
                const float share =
                    step::nearer_middle(__shfl_sync(group.mask(), own, group.first),
                                        __shfl_sync(group.mask(), own, group.first + group.size / 2));
                if (query_.lane == group.first) found |= splitter_.put_share(t, k, share);
            });
        if (grid.any(found)) split(grid, counts);
    }

  private:
    // Calls visit(t, k, group) for the edges k of the triangles t that own them, if they are needed(t, k), by
    // groups of kLanes lanes.
    template <unsigned kLanes, typename Needed, typename Visit>
    __device__ void each_owned_edge(const CooperativeGrid& grid, unsigned triangles, const Needed& needed,
                                    const Visit& visit) const {
        const auto t = [](unsigned i) { return static_cast<std::int32_t>(i / 3); };
        const auto k = [](unsigned i) { return static_cast<int>(i % 3); };
        each_needed(
            grid, 3 * triangles, kLanes,
            [&](unsigned i) { return i < 3 * triangles && splitter_.owns(t(i), k(i)) && needed(t(i), k(i)); },
            [&](unsigned i, const LaneGroup& group) { visit(t(i), k(i), group); });
    }
    __device__ void miss(const CooperativeGrid& grid, unsigned missing) const {
        if (grid.is_first()) s_.totals->missing_capacity = missing;
    }
    __device__ void split(const CooperativeGrid& grid, const step::LatticeCounts& before) const {
        const auto [points, triangles] = splitter_.number(grid, before);
        const SurfaceSizes& sizes = s_.sizes;
        if (points > sizes.most_points || triangles > sizes.most_triangles)
            return miss(grid, step::max_of(points - step::min_of(points, sizes.most_points),
                                           triangles - step::min_of(triangles, sizes.most_triangles)));
        if (grid.is_first()) {
            s_.counts->points = points;
            s_.counts->triangles = triangles;
        }
        splitter_.split(grid);
    }

    const SurfaceState& s_;
    std::int32_t* numbers_;
    WarpQuery query_;
    step::LatticeSplitter<step::SplitView<std::int32_t (*)[3]>> splitter_;
};

__global__ void __launch_bounds__(kGridThreads, 1)
    split_at_silhouettes_kernel(const __grid_constant__ SurfaceState s,
                                const __grid_constant__ SplitArrays a) {
    if (s.totals->missing_capacity > 0) return;
    CooperativeGrid grid(s.board);
    DeviceSplitter(s, a, grid.lane()).split_at_silhouettes(grid);
}

__global__ void __launch_bounds__(kGridThreads, 1)
    split_straddling_kernel(const __grid_constant__ SurfaceState s, const __grid_constant__ SplitArrays a) {
    if (s.totals->missing_capacity > 0) return;
    CooperativeGrid grid(s.board);
    DeviceSplitter(s, a, grid.lane()).split_straddling(grid);
}

}  // namespace

void split_at_silhouettes(const Launch& launch, const SurfaceState& s, const SplitArrays& a) {
    launch_cooperative(launch, split_at_silhouettes_kernel, 0, "splitting triangles", s, a);
}

void split_straddling(const Launch& launch, const SurfaceState& s, const SplitArrays& a) {
    launch_cooperative(launch, split_straddling_kernel, 0, "splitting triangles", s, a);
}

}  // namespace hexrelief::cuda
