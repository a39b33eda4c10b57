// Queries about silhouettes by several lanes of a warp together; the silhouettes' points come from a table.
#pragma once

#include "cuda/common/grid.cuh"
#include "cuda/common/warp_reduce.cuh"
#include "cuda/surface/pixels/crack_query.h"

namespace hexrelief::cuda {

static_assert(step::kDiscontinuityRight == 1 && step::kDiscontinuityDown == 2 && step::kTile_px == 4);

// Does the same as CrackQuery::silhouette_point(), for threads side by side. Each thread first lists the
// crack edges around its own, so that a warp takes as many steps as the longest list has entries, not as many
// as the window has positions.
static __device__ __noinline__ step::SilhouettePoint silhouette_point_anew(step::PixelView pixels,
                                                                           step::Crack c) {
    constexpr int kReach = step::kSilhouetteReach_px, kSide = 2 * kReach + 1;
    static_assert(2 * kSide * kSide <= 64);
    const step::SilhouetteCrack own = step::silhouette_crack(pixels, c);
    unsigned long long cracks = 0;  // two bits per position, right before down
#pragma unroll
    for (int place = 0; place < kSide * kSide; ++place) {
        const int u = c.x - kReach + place % kSide, v = c.y - kReach + place / kSide;
        const bool inside = u >= 0 && v >= 0 && u < pixels.width && v < pixels.height;
        const unsigned discontinuities =
            inside ? pixels.flags[pixels.index(u, v)] & (step::kDiscontinuityRight | step::kDiscontinuityDown)
                   : 0;
        cracks |= static_cast<unsigned long long>(discontinuities) << 2 * place;
    }
    step::SilhouetteSums sums;
    HEXRELIEF_ROLLED
    for (; cracks; cracks &= cracks - 1) {
        const int bit = __ffsll(static_cast<long long>(cracks)) - 1, place = bit / 2, row = place / kSide;
        sums.add(step::silhouette_term(pixels, own, c.x - kReach + place - kSide * row, c.y - kReach + row,
                                       bit & 1));
    }
    return step::silhouette_point_of(own, sums);
}

// Fills the table from the pixels' discontinuities. *a.count must be 0 for all threads.
__device__ inline void find_silhouettes(const CooperativeGrid& grid, const SurfaceState& s,
                                        const SilhouetteArrays& a) {
    const step::PixelView pixels = s.view();
    const unsigned count = s.sizes.pixels(), chunks = (count + 3) / 4, lanes = (chunks + 31) / 32 * 32;
    for (unsigned chunk = grid.thread(); chunk < lanes; chunk += grid.threads()) {
        unsigned flags = 0;
        if (4 * chunk + 4 <= count)
            flags = reinterpret_cast<const unsigned*>(pixels.flags)[chunk];
        else
            for (unsigned k = 0; 4 * chunk + k < count; ++k) flags |= pixels.flags[4 * chunk + k] << (8 * k);
        flags &= 0x01010101u * (step::kDiscontinuityRight | step::kDiscontinuityDown);
        const unsigned own = __popc(flags);
        unsigned firsts[4] = {};
        if (__any_sync(kAllLanes, own != 0)) {
            const unsigned sum = sum_up_to_lane(own);
            unsigned first = grid.lane() == 31 ? atomicAdd(a.count, sum) : 0;
            first = __shfl_sync(kAllLanes, first, 31) + sum - own;
            HEXRELIEF_UNROLL
            for (unsigned k = 0; k < 4; ++k) {
                const unsigned discontinuities = flags >> (8 * k) & 255u, i = 4 * chunk + k;
                firsts[k] = first;
                for (unsigned down = 0; down < 2; ++down) {
                    if (!(discontinuities & (down ? step::kDiscontinuityDown : step::kDiscontinuityRight)))
                        continue;
                    if (first < a.capacity) *reinterpret_cast<uint2*>(a.entries + first) = {i, down};
                    ++first;
                }
            }
        }
        if (chunk < chunks)
            reinterpret_cast<uint4*>(a.firsts)[chunk] = {firsts[0], firsts[1], firsts[2], firsts[3]};
    }
    grid.wait();
    grid.each(min(*a.count, a.capacity), [&](unsigned i) {
        const uint2 at = *reinterpret_cast<const uint2*>(a.entries + i);
        const int y = static_cast<int>(at.x / pixels.width);
        a.entries[i].point = silhouette_point_anew(
            pixels, {static_cast<int>(at.x) - y * pixels.width, y, static_cast<int>(at.y)});
    });
}

// Successive lanes of a warp: the first one, and how many.
struct LaneGroup {
    unsigned first, size;

    __device__ LaneGroup half(unsigned which) const { return {first + which * (size / 2), size / 2}; }
    __device__ unsigned mask() const { return (size == 32 ? kAllLanes : (1u << size) - 1) << first; }
};

// Queries by a group of lanes. All lanes of the group call each function with the same arguments and
// get the same result.
struct GroupQuery {
    step::PixelView pixels;
    SilhouetteArrays silhouettes;
    unsigned lane;  // index in the warp
    LaneGroup group;

    mutable unsigned entry = 0;  // entry of the crack edge that was found last

    // Returns the first discontinuity on the path from a to b, or the last. Each lane takes a step. The entry
    // of a crack edge is loaded before it is known whether there is a discontinuity.
    __device__ step::Crossing walk(const Vec2f& a, const Vec2f& b, bool last) const {
        step::Crossing crossing{false, {0, 0, 0}};
        const step::Way way = step::way_between(a.x, a.y, b.x, b.y);
        const unsigned mask = group.mask();
        HEXRELIEF_ROLLED
        for (int first = 1; first <= way.steps; first += group.size) {
            const int k = min(first + static_cast<int>(lane - group.first), way.steps);
            const step::Pixel from = step::pixel_after(pixels, way, k - 1),
                              to = step::pixel_after(pixels, way, k);
            const step::Crack aside = step::crack_between(from.x, from.y, to.x - from.x, 0),
                              ahead = step::crack_between(to.x, from.y, 0, to.y - from.y);
            const bool moves_aside = to.x != from.x, moves_ahead = to.y != from.y;
            const Seen of_aside = moves_aside ? see(aside.x, aside.y) : Seen{},
                       of_ahead = moves_ahead ? see(ahead.x, ahead.y) : Seen{};
            const bool meets_aside = of_aside.flags & step::kDiscontinuityRight,
                       meets_ahead = of_ahead.flags & step::kDiscontinuityDown;
            const unsigned meeting = __ballot_sync(mask, meets_aside || meets_ahead);
            if (!meeting) continue;
            const int source = last ? 31 - __clz(static_cast<int>(meeting)) : __ffs(meeting) - 1;
            const bool is_aside = meets_aside && !(last && meets_ahead);
            const step::Crack met = is_aside ? aside : ahead;
            entry = __shfl_sync(mask, is_aside ? of_aside.entry(0) : of_ahead.entry(1), source);
            crossing = {true,
                        {__shfl_sync(mask, met.x, source), __shfl_sync(mask, met.y, source),
                         __shfl_sync(mask, met.down, source)}};
            if (!last) break;
        }
        return crossing;
    }
    // Returns the silhouette point of the crack edge found last.
    __device__ step::SilhouettePoint silhouette_point(const step::Crack& c) const {
        if (entry >= silhouettes.capacity) return silhouette_point_anew(pixels, c);
        const float4 point = *reinterpret_cast<const float4*>(silhouettes.entries + entry);
        return {point.x, point.y, point.z, point.w};
    }

    // A pixel's flags and, if it has discontinuities, its first entry.
    struct Seen {
        unsigned flags = 0, first = 0;
        __device__ unsigned entry(int down) const {
            return first + (down && (flags & step::kDiscontinuityRight) ? 1 : 0);
        }
    };
    __device__ Seen see(int x, int y) const {
        const std::size_t i = pixels.index(x, y);
        return {pixels.flags[i], silhouettes.firsts[i]};
    }
};

// Queries by a whole warp.
struct WarpQuery : GroupQuery {
    step::TileView tiles;

    __device__ static WarpQuery of(const SurfaceState& s, const SilhouetteArrays& silhouettes,
                                   unsigned lane) {
        return {{s.view(), silhouettes, lane, {0, 32}}, s.tiles()};
    }
    __device__ GroupQuery part(const LaneGroup& lanes) const { return {pixels, silhouettes, lane, lanes}; }

    // pairs of tiles at a time, because loading their pixels takes long
    static constexpr unsigned kAtOnce = 3;

    __device__ step::Crack nearest_crack(const Vec2f& p, float reach_px) const {
        constexpr float kNoTile_px2 = 3.0e38f;
        // px2: tiles up to this distance, or twice that of the nearest tile plus this, are
        // searched together with it
        constexpr float kTogether_px2 = 16;
        const step::PixelWindow window = step::window_around(pixels, p, reach_px);
        const int columns = step::tiles_across(window), count = columns * step::tiles_down(window);
        const step::CrackOrder order(window);
        const std::uint64_t none = order.none(reach_px);
        std::uint64_t best = none;
        HEXRELIEF_ROLLED
        for (int first = 0; first < count; first += 32) {
            const int tile = first + static_cast<int>(lane), row = tile / columns;
            const step::PixelWindow mine = step::tile_of(window, tile - row * columns, row);
            float away = kNoTile_px2;
            if (tile < count && step::tile_matters(tiles, mine, p, order.distance2(best)))
                away = step::least_distance2(mine, p);
            HEXRELIEF_ROLLED
            for (;;) {
                // the nearest tiles first, after which the others may no longer matter
                const float least_away = least_of_lanes(away);
                if (!(least_away <= order.distance2(best))) break;
                const bool is_next = away <= 2 * least_away + kTogether_px2;
                const unsigned next = __ballot_sync(kAllLanes, is_next);
                if (is_next && count_before_lane(next) < 2 * kAtOnce) away = kNoTile_px2;
                const Ranked own = first_crack_of_lane(window, next, first, p, best);
                const std::uint64_t least =
                    reduce_warp(own.rank, [](std::uint64_t a, std::uint64_t b) { return min(a, b); });
                if (least == best) continue;
                best = least;
                entry =
                    __shfl_sync(kAllLanes, own.entry, __ffs(__ballot_sync(kAllLanes, own.rank == best)) - 1);
            }
        }
        return best == none ? step::Crack{-1, -1, 0} : order.crack(best);
    }

  private:
    // A crack edge's rank in the order of the window, and its entry.
    struct Ranked {
        std::uint64_t rank;
        unsigned entry;
    };
    // Returns the first of the crack edges that the lane reads, if it comes before `best`. next: bits
    // of tiles, counted from `tile` on. The first 2 * kAtOnce of them are read, two tiles at a time,
    // with a pixel per lane.
    __device__ Ranked first_crack_of_lane(const step::PixelWindow& window, unsigned next, int tile,
                                          const Vec2f& p, std::uint64_t best) const {
        const int columns = step::tiles_across(window);
        const step::CrackOrder order(window);
        Ranked first{best, 0};
        int x[kAtOnce], y[kAtOnce];
        Seen seen[kAtOnce];
        HEXRELIEF_UNROLL
        for (unsigned k = 0; k < kAtOnce; ++k) {
            const int one = __ffs(next) - 1;
            next &= next - 1;
            const int two = __ffs(next) - 1;  // -1: none
            next &= next - 1;
            const int own = lane < 16 ? one : two, own_tile = tile + own, own_row = own_tile / columns;
            const step::PixelWindow w = step::tile_of(window, own_tile - own_row * columns, own_row);
            x[k] = w.x0 + static_cast<int>(lane % 4);
            y[k] = w.y0 + static_cast<int>(lane / 4 % 4);
            const bool inside = own >= 0 && x[k] <= w.x1 && y[k] <= w.y1;
            seen[k] = inside ? see(x[k], y[k]) : Seen{};
        }
        HEXRELIEF_UNROLL
        for (unsigned k = 0; k < kAtOnce; ++k) {
            HEXRELIEF_UNROLL
            for (int down = 0; down < 2; ++down) {
                if (!(seen[k].flags & (down ? step::kDiscontinuityDown : step::kDiscontinuityRight)))
                    continue;
                const step::Crack c{x[k], y[k], down};
                const std::uint64_t rank = order.rank(c, step::distance2_to(c, p));
                if (rank < first.rank) first = {rank, seen[k].entry(down)};
            }
        }
        return first;
    }
};

// Calls visit(i, group) for each i < count that is needed, by groups of `lanes` lanes; needed(i) is evaluated
// by one lane for each i. Successive items go to different warps, because items that take long lie close
// together. needed(i) is called by all lanes, also for i >= count.
template <typename Needed, typename Visit>
__device__ void each_needed(const CooperativeGrid& grid, unsigned count, unsigned lanes, const Needed& needed,
                            const Visit& visit) {
    const unsigned warps = grid.warps(), warp = grid.warp();
    const LaneGroup group{grid.lane() / lanes * lanes, lanes};
    HEXRELIEF_ROLLED
    for (unsigned first = warp; first < count; first += 32 * warps) {
        unsigned waiting = __ballot_sync(kAllLanes, needed(first + grid.lane() * warps));
        HEXRELIEF_ROLLED
        while (waiting) {
            unsigned own = 0;  // 1 + lane, of this group
            for (unsigned g = 0; g < 32; g += lanes) {
                if (g == group.first) own = __ffs(waiting);
                waiting &= waiting - 1;
            }
            if (own) visit(first + (own - 1) * warps, group);
            __syncwarp();
        }
    }
}

}  // namespace hexrelief::cuda
