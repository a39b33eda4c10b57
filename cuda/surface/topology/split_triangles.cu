#include "cuda/surface/topology/split_triangles.h"

#include "cuda/common/grid.cuh"
#include "cuda/common/grid_scan.cuh"
#include "cuda/surface/pixels/crack_query.cuh"

namespace hexrelief::cuda {
namespace {

class DeviceSplitter {
  public:
    __device__ DeviceSplitter(const SurfaceState& s, const SplitArrays& a, unsigned lane)
        : s_(s), a_(a), query_(WarpQuery::of(s, a.silhouettes, lane)), points_(0), triangles_(0) {}

    __device__ void split_at_silhouettes(CooperativeGrid& grid) {
        points_ = s_.sizes.vertices();
        if (!open_lattice(grid)) return;
        bool found = false;
        const unsigned edges = 3 * slots();
        each_needed(
            grid, edges, 16, [&](unsigned i) { return i < edges && join(i / 3, static_cast<int>(i % 3)); },
            [&](unsigned i, const LaneGroup& group) {
                const unsigned slot = i / 3;
                const int k = static_cast<int>(i % 3);
                const std::int32_t t = a_.numbers[slot];
                const Ends e = ends(t, k);
                const float share =
                    step::open_crossing(query_.part(group), e.p, s_.lattice.on_silhouette[e.a], e.q,
                                        s_.lattice.on_silhouette[e.b], true);
                if (query_.lane != group.first || !step::splits_at(share)) return;
                const int across = step::slot_across(s_.sizes.columns, s_.sizes.rows, slot, k);
                const std::int32_t n = across < 0 ? -1 : a_.numbers[across];
                a_.shares[t][k] = share;
                if (n >= 0) a_.shares[n][edge_of_slot(across, static_cast<int>(slot))] = share;
                found = true;
            });
        if (grid.any(found)) cut(grid);
    }
    __device__ void split_straddling(CooperativeGrid& grid) {
        points_ = s_.counts->points;
        triangles_ = s_.counts->triangles;
        bool found = false;
        const unsigned edges = 3 * triangles_;
        const std::uint8_t* straddling = s_.labels.straddling;
        each_needed(
            grid, edges, 32,
            [&](unsigned i) {
                if (i >= edges) return false;
                const std::int32_t t = static_cast<std::int32_t>(i / 3), n = s_.lattice.neighbours[t][i % 3];
                return (n < 0 || n > t) && (straddling[t] || (n >= 0 && straddling[n]));
            },
            [&](unsigned i, const LaneGroup& group) {
                const std::int32_t t = static_cast<std::int32_t>(i / 3);
                const int k = static_cast<int>(i % 3);
                const Ends e = ends(t, k);
                const unsigned forth = (query_.lane - group.first) / (group.size / 2);
                const float own =
                    step::crossing_from_middle(query_.part(group.half(forth)), e.p, e.q, !forth);
                const float share =
                    step::nearer_middle(__shfl_sync(group.mask(), own, group.first),
                                        __shfl_sync(group.mask(), own, group.first + group.size / 2));
                if (query_.lane != group.first || !step::splits_at(share)) return;
                const std::int32_t n = s_.lattice.neighbours[t][k];
                a_.shares[t][k] = share;
                if (n >= 0) a_.shares[n][step::edge_towards(s_.lattice.neighbours[n], t)] = share;
                found = true;
            });
        if (grid.any(found)) cut(grid);
    }

  private:
    __device__ unsigned slots() const {
        const SurfaceSizes& sizes = s_.sizes;
        return sizes.columns < 2 || sizes.rows < 2
                   ? 0
                   : 2 * static_cast<unsigned>(sizes.columns - 1) * (sizes.rows - 1);
    }
    __device__ Triangle corners_of_slot(unsigned slot) const {
        const unsigned quad = slot / 2, columns = s_.sizes.columns - 1;
        return quad_triangles(s_.sizes.columns, static_cast<int>(quad % columns),
                              static_cast<int>(quad / columns))[slot & 1];
    }
    __device__ int edge_of_slot(int slot, int towards) const {
        HEXRELIEF_ROLLED
        for (int k = 0; k < 3; ++k)
            if (step::slot_across(s_.sizes.columns, s_.sizes.rows, slot, k) == towards) return k;
        return 0;
    }
    __device__ void miss(const CooperativeGrid& grid, unsigned missing) const {
        if (grid.thread() == 0) s_.totals->missing_capacity = missing;
    }

    // Numbers the triangles of the lattice; returns false if their number exceeds the capacity.
    __device__ bool open_lattice(const CooperativeGrid& grid) {
        const auto has_area = [&](unsigned slot) {
            const Triangle t = corners_of_slot(slot);
            const Vec2f* p = s_.lattice.points;
            return step::has_area(p[t[0]], p[t[1]], p[t[2]]) ? 1u : 0u;
        };
        triangles_ = exclusive_scan(
            grid, slots(),
            [&](unsigned slot) {
                const unsigned kept = has_area(slot);
                a_.numbers[slot] = kept ? 0 : -1;
                return kept;
            },
            [&](unsigned slot) { return a_.numbers[slot] < 0 ? 0u : 1u; },
            [&](unsigned slot, unsigned number) {
                if (a_.numbers[slot] < 0 || number >= s_.sizes.most_triangles) return;
                a_.numbers[slot] = static_cast<std::int32_t>(number);
                s_.lattice.triangles[number] = corners_of_slot(slot);
                s_.lattice.changed[number] = kNewTriangle;
                clear_shares(number);
            });
        if (triangles_ > s_.sizes.most_triangles) {
            miss(grid, triangles_ - s_.sizes.most_triangles);
            return false;
        }
        if (grid.thread() == 0) *s_.counts = {points_, triangles_, 0, 0};
        return true;
    }
    // Writes the neighbour across an edge. Returns true if the edge is this triangle's own and
    // may cross a silhouette.
    __device__ bool join(unsigned slot, int k) const {
        const std::int32_t t = a_.numbers[slot];
        if (t < 0) return false;
        const int across = step::slot_across(s_.sizes.columns, s_.sizes.rows, static_cast<int>(slot), k);
        const std::int32_t n = across < 0 ? -1 : a_.numbers[across];
        s_.lattice.neighbours[t][k] = n;
        if (n >= 0 && n < t) return false;
        const Ends e = ends(t, k);
        return !(s_.lattice.on_silhouette[e.a] && s_.lattice.on_silhouette[e.b]) &&
               step::may_cross(s_.tiles(), e.p, e.q);
    }

    struct Ends {
        std::uint32_t a, b;  // a < b
        Vec2f p, q;
    };
    __device__ Ends ends(std::int32_t t, int k) const {
        const Triangle& corners = s_.lattice.triangles[t];
        const std::uint32_t u = corners[k], v = corners[step::turned(k, 1)];
        const std::uint32_t a = step::min_of(u, v), b = step::max_of(u, v);
        return {a, b, s_.lattice.points[a], s_.lattice.points[b]};
    }
    __device__ void clear_shares(unsigned t) const {
        for (int k = 0; k < 3; ++k) a_.shares[t][k] = -1;
    }
    __device__ step::Cut cut_of(std::int32_t t) const {
        unsigned edges = 0, owned = 0;
#pragma unroll
        for (int k = 0; k < 3; ++k)
            if (step::splits_at(a_.shares[t][k])) edges |= 1u << k;
        if (edges == 0) return {};
        int across[3];
        Vec2f places[6];
#pragma unroll
        for (int k = 0; k < 3; ++k) {
            const std::int32_t n = s_.lattice.neighbours[t][k];
            across[k] = n < 0 ? 0 : step::edge_towards(s_.lattice.neighbours[n], t);
            if (n < 0 || n > t) owned |= edges & 1u << k;
            places[k] = s_.lattice.points[s_.lattice.triangles[t][k]];
            places[3 + k] = on_edge(t, k);
        }
        return step::cut_triangle(edges, owned, across, [&](int corner) { return places[corner]; });
    }
    __device__ Vec2f on_edge(std::int32_t t, int k) const {
        const Ends e = ends(t, k);
        return step::between(e.p, e.q, a_.shares[t][k]);
    }
    // Cuts the triangles whose edges have shares, and clears the shares.
    __device__ void cut(const CooperativeGrid& grid) const {
        const auto new_ones = [&](unsigned t) {  // points in the upper half, triangles in the lower half
            const step::Cut cut = a_.cuts[t];
            return static_cast<unsigned long long>(cut.new_points()) << 32 |
                   static_cast<unsigned>(cut.new_triangles());
        };
        if (grid.thread() == 0) *a_.count = 0;  // written before the first barrier, counted up after it
        const unsigned long long all = exclusive_scan(
            grid, triangles_,
            [&](unsigned t) {
                a_.cuts[t] = cut_of(static_cast<std::int32_t>(t));
                return new_ones(t);
            },
            new_ones,
            [&](unsigned t, unsigned long long before) {
                if (a_.cuts[t].bits == 0) return;
                a_.firsts[t] = {points_ + static_cast<unsigned>(before >> 32),
                                triangles_ + static_cast<unsigned>(before)};
                a_.list[atomicAdd(a_.count, 1u)] = t;
            });
        const unsigned points = points_ + static_cast<unsigned>(all >> 32),
                       triangles = triangles_ + static_cast<unsigned>(all);
        if (points > s_.sizes.most_points || triangles > s_.sizes.most_triangles)
            return miss(grid, step::max_of(points - step::min_of(points, s_.sizes.most_points),
                                           triangles - step::min_of(triangles, s_.sizes.most_triangles)));
        if (grid.thread() == 0) {
            s_.counts->points = points;
            s_.counts->triangles = triangles;
        }
        // sixteen lanes per triangle, which read the old values before any of them writes
        const unsigned count = *a_.count, lanes = (16 * count + 31) / 32 * 32;
        HEXRELIEF_ROLLED
        for (unsigned i = grid.thread(); i < lanes; i += grid.threads())
            split(i / 16 < count ? static_cast<std::int32_t>(a_.list[i / 16]) : -1, static_cast<int>(i % 16));
        grid.wait();
    }
    // Writes a cut triangle. The first twelve lanes each write an edge of a part, the next three the
    // triangle's own edges: their new points, and the links from uncut neighbours to the parts. No other
    // triangle's corners and neighbours are read.
    __device__ void split(std::int32_t t, int lane) const {
        const step::Cut cut = t < 0 ? step::Cut{} : a_.cuts[t];
        const SplitFirsts first = t < 0 ? SplitFirsts{} : a_.firsts[t];
        const int part = lane / 3, i = lane - 3 * part;
        const bool of_part = part < 4 && cut.has_part(part), own = t >= 0 && part == 4;
        std::uint32_t corner = 0;
        std::int32_t leads_to = -1;
        if (of_part || own) {
            const step::PartCorners c =
                of_part ? step::part_corners(cut, part) : step::PartCorners{{0, 1, 2}};
            const int from = i == 0 ? c.at[0] : i == 1 ? c.at[1] : c.at[2];
            const int to = i == 0 ? c.at[1] : i == 1 ? c.at[2] : c.at[0];
            const int k = of_part ? step::edge_of(from, to) : -1;
            if (of_part) corner = vertex(cut, first, t, from);
            leads_to = k < 0 ? t : s_.lattice.neighbours[t][k];
            if (leads_to >= 0) {
                const int j = k < 0 ? 0 : cut.edge_across(k);
                leads_to =
                    number_at(leads_to, k < 0 ? from : step::corner_across(from, k, j),
                              k < 0 ? to : step::corner_across(to, k, j), of_part && k < 0 ? part : -1);
            }
        }
        if (own) {
            if (cut.owned() >> i & 1u) s_.lattice.points[cut.point(i, first.point)] = on_edge(t, i);
            const std::int32_t n = s_.lattice.neighbours[t][i];
            if (n >= 0 && a_.cuts[n].bits == 0) s_.lattice.neighbours[n][cut.edge_across(i)] = leads_to;
        }
        __syncwarp();
        if (own) a_.shares[t][i] = -1;
        if (!of_part) return;
        const std::uint32_t number = cut.number(part, t, first.triangle);
        s_.lattice.triangles[number][i] = corner;
        s_.lattice.neighbours[number][i] = leads_to;
        if (number >= triangles_) a_.shares[number][i] = -1;
        if (i == 0 && cut.edges() != 0) s_.lattice.changed[number] = kNewTriangle;
    }
    __device__ std::uint32_t vertex(const step::Cut& cut, const SplitFirsts& first, std::int32_t t,
                                    int corner) const {
        if (corner < 3) return s_.lattice.triangles[t][corner];
        const int k = corner - 3;
        if (cut.owned() >> k & 1u) return cut.point(k, first.point);
        const std::int32_t n = s_.lattice.neighbours[t][k];
        return a_.cuts[n].point(cut.edge_across(k), a_.firsts[n].point);
    }
    // Returns the number of the part of triangle t that touches both corners.
    __device__ std::int32_t number_at(std::int32_t t, int a, int b, int other_than) const {
        const step::Cut cut = a_.cuts[t];
        if (cut.bits == 0) return t;
        const int part = step::part_at(cut, a, b, other_than);
        return part < 0 ? -1 : static_cast<std::int32_t>(cut.number(part, t, a_.firsts[t].triangle));
    }

    static constexpr std::uint8_t kNewTriangle = 2;  // SplitLattice::kNew

    const SurfaceState& s_;
    const SplitArrays& a_;
    WarpQuery query_;
    unsigned points_, triangles_;  // before the split
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
