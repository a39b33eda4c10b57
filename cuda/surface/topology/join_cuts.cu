#include "cuda/surface/topology/join_cuts.h"

#include "cuda/common/grid.cuh"
#include "cuda/surface/topology/surface_difference.cuh"

namespace hexrelief::cuda {
namespace {

// Opens edges in the order of their numbers as far as it matters: an edge is decided once no lower edge at
// its ends is undecided.
class DeviceCuts {
  public:
    __device__ DeviceCuts(const SurfaceState& s, const CutArrays& a) : s_(s), a_(a) {}

    __device__ void join(CooperativeGrid& grid) const {
        const unsigned points = s_.counts->points, triangles = s_.counts->triangles;
        if (grid.thread() == 0) *a_.count = 0;
        grid.each(points, [&](unsigned v) {
            a_.cuts[v] = 0;
            a_.next_edges[0][v] = a_.next_edges[1][v] = ~0ull;
        });
        each_edge(grid, triangles, [&](const Edge& e) {
            if (e.kept != e.other_kept || (e.kept && e.open)) count(e);
        });
        unsigned round = 0;
        each_edge(grid, triangles, [&](const Edge& e) {
            if (!e.kept || !e.other_kept || e.open) return;
            if (a_.cuts[e.a] != 1 || a_.cuts[e.b] != 1) return;
            a_.joins[atomicAdd(a_.count, 1)] = e.number();
            queue(e, round);
        });
        open(grid, round);
    }

  private:
    static constexpr std::uint32_t kNone = 0xffffffffu;
    struct Edge {
        std::uint32_t t, k;
        std::int32_t n;      // the triangle across the edge
        std::uint32_t a, b;  // its end vertices
        bool kept = false, other_kept = false, open = false;
        __device__ std::uint32_t number() const { return 3 * t + k; }
    };

    __device__ Edge edge(std::uint32_t number) const {
        const std::uint32_t t = number / 3, k = number % 3;
        const Triangle& v = s_.lattice.triangles[t];
        return {t, k, s_.lattice.neighbours[t][k], v[k], v[(k + 1) % 3]};
    }
    // Calls visit(edge) for each edge once, from its lower triangle, with all members set.
    template <typename Visit>
    __device__ void each_edge(CooperativeGrid& grid, unsigned triangles, const Visit& visit) const {
        grid.each(triangles, [&](unsigned t) {
            const Triangle v = s_.lattice.triangles[t];
            const auto& around = s_.lattice.neighbours[t];
            const bool kept = s_.labels.kept[t] != 0;
            Edge edges[3];  // all three are read first, because each load takes long
            HEXRELIEF_UNROLL
            for (std::uint32_t k = 0; k < 3; ++k) {
                const std::int32_t n = around[k];
                edges[k] = {t,
                            k,
                            n,
                            v[k],
                            v[(k + 1) % 3],
                            kept,
                            n >= 0 && s_.labels.kept[n],
                            s_.labels.open[t][k] != 0};
            }
            HEXRELIEF_UNROLL
            for (const Edge& e : edges)
                if (e.n < 0 || e.n > static_cast<std::int32_t>(t)) visit(e);
        });
    }
    __device__ void count(const Edge& e) const {
        atomicAdd(&a_.cuts[e.a], 1);
        atomicAdd(&a_.cuts[e.b], 1);
    }
    // Returns a number that orders edges; those of later rounds are lower, so that they replace earlier ones.
    __device__ static unsigned long long priority(const Edge& e, unsigned round) {
        return static_cast<unsigned long long>(~round) << 32 | e.number();
    }
    __device__ void queue(const Edge& e, unsigned round) const {
        unsigned long long* const next_edges = a_.next_edges[round % 2];
        atomicMin(&next_edges[e.a], priority(e, round));
        atomicMin(&next_edges[e.b], priority(e, round));
    }
    // Opens the listed edges whose ends have one cut each when it is their turn.
    __device__ void open(CooperativeGrid& grid, unsigned round) const {
        const unsigned listed = *a_.count;
        for (bool left = true; left; ++round) {
            bool waits = false;
            for (unsigned i = grid.thread(); i < listed; i += grid.threads()) {
                if (a_.joins[i] == kNone) continue;
                const Edge e = edge(a_.joins[i]);
                const volatile unsigned* const cuts = a_.cuts;
                const unsigned a = cuts[e.a], b = cuts[e.b];
                const unsigned long long own = priority(e, round), *next = a_.next_edges[round % 2];
                const bool now = next[e.a] == own && next[e.b] == own;
                if (now && a == 1 && b == 1) {
                    open_edge(e);
                    count(e);
                }
                if (now || a > 1 || b > 1) {
                    a_.joins[i] = kNone;
                } else {
                    queue(e, round + 1);
                    waits = true;
                }
            }
            left = grid.any(waits);
        }
    }
    __device__ void open_edge(const Edge& e) const {
        s_.labels.open[e.t][e.k] = 1;
        for (int m = 0; m < 3; ++m)
            if (s_.lattice.neighbours[e.n][m] == static_cast<std::int32_t>(e.t)) {
                s_.labels.open[e.n][m] = 1;
                break;
            }
    }

    const SurfaceState& s_;
    const CutArrays& a_;
};

__global__ void __launch_bounds__(kGridThreads, 1)
    join_cuts_kernel(const __grid_constant__ SurfaceState s, const __grid_constant__ CutArrays a) {
    if (s.totals->missing_capacity > 0) return;
    CooperativeGrid grid(s.board);
    DeviceCuts(s, a).join(grid);
}

}  // namespace

void join_cuts(const Launch& launch, const SurfaceState& s, const CutArrays& a) {
    launch_cooperative(launch, join_cuts_kernel, 0, "joining cuts", s, a);
}

}  // namespace hexrelief::cuda
