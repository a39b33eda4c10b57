// Processes several triangles per warp, each by a group of lanes that take a row of pixels each. The groups
// of a warp advance together: all lanes of the warp must call each function here together.
#pragma once

#include <cstdint>

#include "cuda/common/grid.cuh"
#include "cuda/common/warp_reduce.cuh"
#include "mesher/surface/topology/rasterize_step.h"
#include "pipeline/base/host_device.h"

namespace hexrelief::cuda {

inline constexpr unsigned kLeastGroup = 8;

// A group of lanes of a warp; its size is a power of 2.
struct TriangleLanes {
    unsigned size, lane, shift;

    __device__ explicit TriangleLanes(unsigned lanes = kLeastGroup)
        : size(lanes), lane(threadIdx.x % lanes), shift(threadIdx.x % 32 - lane) {}
    // Returns a bit for each lane of the group.
    __device__ unsigned ballot(bool mine) const {
        return __ballot_sync(kAllLanes, mine) >> shift & (~0u >> (32 - size));
    }
    // Returns the value of another lane of the group.
    template <typename T>
    __device__ T from(T value, unsigned source) const {
        return __shfl_sync(kAllLanes, value, shift + source);
    }
    // Returns the sum over the preceding lanes of the group; total: over all of them.
    __device__ unsigned sum_before(unsigned mine, unsigned& total) const {
        const unsigned sum = sum_up_to_lane(mine, size);
        total = from(sum, size - 1);
        return sum - mine;
    }
    // Reduces the values of the group's lanes by join(a, b).
    template <typename T, typename Join>
    __device__ T joined(T value, const Join& join) const {
        for (unsigned step = 1; step < size; step *= 2)
            value = join(value, __shfl_xor_sync(kAllLanes, value, step));
        return value;
    }
    template <typename T>
    __device__ T sum(T mine) const {
        return joined(mine, [](T a, T b) { return a + b; });
    }
};

// Calls visit(i, has, group) for each i < large + count. Each of the first `large` gets a whole warp; each
// other one gets as many lanes as there are, or `least` if there are many. Successive indices go to different
// warps, and warps that are done take further ones. *taken must be 0 before.
template <typename Visit>
__device__ void each_by_group(const CooperativeGrid& grid, unsigned large, unsigned count, unsigned least,
                              unsigned* taken, const Visit& visit) {
    constexpr unsigned kMany = 4;  // per group of kLeastGroup lanes
    const unsigned warps = grid.warps(), left = warps - min(warps / 2, large);
    unsigned size = 32;
    while (size > kLeastGroup && count > 32 / size * left) size /= 2;
    if (count > kMany * 32 / kLeastGroup * warps) size = least;
    const unsigned small = (count + 32 / size - 1) / (32 / size), all = large + small;
    HEXRELIEF_ROLLED
    for (unsigned item = grid.warp(); item < all;) {
        unsigned next = 0;  // loaded long before it is needed
        if (all > warps && grid.lane() == 0) next = atomicAdd(taken, 1);
        const TriangleLanes group(item < large ? 32 : size);
        const unsigned i = item + (item < large ? 0 : group.shift / size * small);
        visit(i, i < large + count, group);
        item = all > warps ? warps + __shfl_sync(kAllLanes, next, 0) : all;
    }
}
// Calls visit(i, has, group) for each i < count for which wanted(i), called by single lanes, is true. The
// fewer of a warp's indices are wanted, the larger are the groups.
template <typename Wanted, typename Visit>
__device__ void each_wanted_by_group(const CooperativeGrid& grid, unsigned count, const Wanted& wanted,
                                     const Visit& visit) {
    const unsigned warps = grid.warps(), lane = threadIdx.x % 32;
    HEXRELIEF_ROLLED
    for (unsigned start = grid.warp(); start < count; start += 32 * warps) {
        const unsigned mine = start + lane * warps;
        unsigned left = __ballot_sync(kAllLanes, mine < count && wanted(mine));
        HEXRELIEF_ROLLED
        while (left) {
            const unsigned many = __popc(left);
            const TriangleLanes group(many == 1 ? 32 : many == 2 ? 16 : kLeastGroup);
            unsigned own = 0;
            HEXRELIEF_ROLLED
            for (unsigned first = 0; first < 32; first += group.size, left &= left - 1)
                if (first == group.shift) own = left;
            visit(own ? start + (__ffs(static_cast<int>(own)) - 1) * warps : 0, own != 0, group);
        }
    }
}

// One lane's row of its group's triangle.
struct GroupRow {
    surface::PixelRun
        run;           // without pixels if the row lies beyond the triangle or none of its pixels lie in it
    bool own = false;  // true if it has pixels
    unsigned all = 0;  // the lanes of the group whose rows have pixels, a bit each
    surface::PixelRun above;  // the preceding row; without pixels if it lies beyond the triangle
    surface::PixelRun upper;  // the last row above with pixels
    bool has_upper = false;
    unsigned upper_lane = 0;  // lane of `upper`, unless it was among the rows of the preceding call
    bool upper_before = false;
};

// Calls visit(row) for the rows of each group's triangle, as many at a time as the group has lanes, and for
// `beyond` rows below the last one.
template <typename Visit>
__device__ void each_row_by_group(const TriangleLanes& group, const surface::TriangleRows& rows, bool has,
                                  int beyond, const Visit& visit) {
    surface::PixelRun last,
        final{rows.first() - 1, 0, 0};  // `last`: the last row with pixels; `final`: the last row
    bool has_last = false;
    HEXRELIEF_ROLLED
    for (int start = rows.first(); __any_sync(kAllLanes, has && start < rows.end() + beyond);
         start += static_cast<int>(group.size)) {
        const int y = start + static_cast<int>(group.lane);
        GroupRow row;
        row.run = {y, 0, 0};
        if (has && y < rows.end()) row.run = rows.run(y);
        row.own = row.run.first < row.run.end;
        row.all = group.ballot(row.own);
        const unsigned lower = row.all & ((1u << group.lane) - 1);
        const auto row_of = [&](unsigned source) {
            return surface::PixelRun{start + static_cast<int>(source), group.from(row.run.first, source),
                                     group.from(row.run.end, source)};
        };
        const auto last_of = [](unsigned lanes) { return lanes ? 31 - __clz(lanes) : 0; };
        row.above = row_of(group.lane ? group.lane - 1 : 0);
        row.upper_lane = last_of(lower);
        row.upper = row_of(row.upper_lane);
        if (group.lane == 0) row.above = final;
        row.upper_before = lower == 0;
        row.has_upper = lower != 0 || has_last;
        if (lower == 0) row.upper = last;
        final = row_of(group.size - 1);
        const surface::PixelRun lowest = row_of(last_of(row.all));
        if (row.all) {
            last = lowest;
            has_last = true;
        }
        visit(row);
    }
}

}  // namespace hexrelief::cuda
