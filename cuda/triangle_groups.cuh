// Four triangles at once by a warp, each by a group of eight lanes that have a row of pixels each. The groups
// keep step: all lanes of the warp call everything here together.
#pragma once

#include <cstdint>

#include "cuda/triangle_warp.cuh"
#include "mesher/steps/triangle_pixels.h"

namespace hexrelief::cuda {

inline constexpr unsigned kGroup = 8;

struct TriangleLanes {
    unsigned lane = threadIdx.x % kGroup, shift = threadIdx.x % 32 - threadIdx.x % kGroup;

    // Of the group's lanes.
    __device__ unsigned ballot(bool mine) const { return __ballot_sync(kAllLanes, mine) >> shift & 0xffu; }
    template <typename T>
    __device__ T from(T value, unsigned source) const {
        return __shfl_sync(kAllLanes, value, source, kGroup);
    }
};

// Calls visit(i, has) for each i < count with wanted(i), which single lanes ask; groups without one have
// has = false. Numbers next to each other go to different warps.
template <typename Crew, typename Wanted, typename Visit>
__device__ void each_wanted_by_group(const Crew& crew, unsigned count, const Wanted& wanted,
                                     const Visit& visit) {
    const TriangleLanes group;
    const unsigned warps = crew.threads() / 32, groups = crew.threads() / kGroup;
    unsigned start = crew.thread() / 32 + group.shift / kGroup * warps;
    for (; __any_sync(kAllLanes, start < count); start += kGroup * groups) {
        const unsigned mine = start + group.lane * groups;
        unsigned left = group.ballot(mine < count && wanted(mine));
        __syncwarp();
        for (; __any_sync(kAllLanes, left != 0); left &= left - 1)
            visit(left ? start + (__ffs(static_cast<int>(left)) - 1) * groups : 0, left != 0);
    }
}

// A row of a lane's group.
struct GroupRow {
    PixelRun run;      // no pixels: beyond the triangle, or none of them lie in it
    bool own = false;  // whether there are
    unsigned all = 0;  // the group's lanes that have some
    PixelRun upper;    // the last row with pixels above
    bool has_upper = false;
};

// Calls visit(row) for eight rows of each group's triangle after the other.
template <typename Visit>
__device__ void each_row_by_group(const TriangleRows& rows, bool has, const Visit& visit) {
    const TriangleLanes group;
    PixelRun last;
    bool has_last = false;
    for (int start = rows.first(); __any_sync(kAllLanes, has && start < rows.end()); start += kGroup) {
        const int y = start + static_cast<int>(group.lane);
        GroupRow row;
        row.run = {y, 0, 0};
        if (has && y < rows.end()) row.run = rows.run(y);
        row.own = row.run.first < row.run.end;
        row.all = group.ballot(row.own);
        const unsigned above = row.all & ((1u << group.lane) - 1);
        const auto row_of = [&](unsigned lanes) {
            const unsigned source = lanes ? 31 - __clz(lanes) : 0;
            return PixelRun{start + static_cast<int>(source), group.from(row.run.first, source),
                            group.from(row.run.end, source)};
        };
        const PixelRun upper = row_of(above), lowest = row_of(row.all);
        row.has_upper = above != 0 || has_last;
        row.upper = above ? upper : last;
        visit(row);
        if (row.all) {
            last = lowest;
            has_last = true;
        }
    }
}

}  // namespace hexrelief::cuda
