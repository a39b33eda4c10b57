// Finds the connected components of a triangle's pixels, as TriangleComponents does, by a group of lanes.
#pragma once

#include <cstdint>

#include "cuda/common/flag_words.cuh"
#include "cuda/common/grid.cuh"
#include "cuda/common/triangle_groups.cuh"
#include "cuda/surface/topology/label_triangles.h"
#include "mesher/surface/topology/label_triangles_step.h"

namespace hexrelief::cuda {

inline constexpr unsigned kSegmentsPerLane = 6;  // that fit into shared memory
inline constexpr unsigned kComponentSharedBytes =
    kGridThreads * kSegmentsPerLane * (sizeof(RowSegment) + sizeof(unsigned));

// Returns the group's own part of the block's shared memory.
__device__ inline ComponentArrays shared_components(const TriangleLanes& group) {
    extern __shared__ RowSegment shared_segments[];
    const unsigned first = (threadIdx.x - group.lane) * kSegmentsPerLane;
    return {shared_segments + first,
            reinterpret_cast<unsigned*>(shared_segments + kGridThreads * kSegmentsPerLane) + first};
}

class GroupComponents {
  public:
    __device__ GroupComponents(const step::PixelView& view, const FlagWords& words,
                               const TriangleLanes& group, const ComponentArrays& arrays)
        : view_(view), words_(words), group_(group), arrays_(arrays) {}

    // Finds the components, and the largest of them, the first of equal ones.
    __device__ void find(const surface::TriangleRows& rows, bool has) {
        unsigned upper_first = 0;  // first segment of the last row with pixels
        each_row_by_group(group_, rows, has, 0, [&](const GroupRow& row) {
            const unsigned own =
                row.own ? 1 + words_.discontinuities_right(row.run.y, row.run.first, row.run.end - 1) : 0;
            unsigned all = 0;
            const unsigned first = count_ + group_.sum_before(own, all);
            if (row.own) put(row.run, first);
            const bool is_free = is_free_bridge(row);
            const unsigned above = group_.from(first, row.upper_lane),
                           lowest = group_.from(first, row.all ? 31 - __clz(row.all) : 0);
            const unsigned upper = row.upper_before ? upper_first : above;
            if (row.all) upper_first = lowest;
            count_ += all;
            __syncwarp();
            // A segment links to the first segment above that it touches. The few that touch further ones are
            // joined in a second pass.
            bool more = false;
            HEXRELIEF_ROLLED
            for (bool again = false;; again = true) {
                if (row.own && row.has_upper && (!again || more))
                    each_link(row.upper, upper, row.run, first, is_free, [&](unsigned i, unsigned j) {
                        if (again) return join(i, j);
                        const unsigned parent = arrays_.segments[j].parent;
                        if (parent == j)
                            arrays_.segments[j].parent = i;
                        else
                            more |= parent != i;
                    });
                __syncwarp();
                if (again || !__any_sync(kAllLanes, more)) break;
                flatten();
            }
        });
        flatten();
        measure();
    }
    // Calls visit(segment, whether it is of the largest component) for all segments, each by some lane.
    template <typename Visit>
    __device__ void each(const Visit& visit) const {
        HEXRELIEF_ROLLED
        for (unsigned k = group_.lane; k < count_; k += group_.size)
            visit(arrays_.segments[k], arrays_.segments[k].parent == largest_);
    }
    // Does the same by one lane, in the order of the segments.
    template <typename Visit>
    __device__ void each_in_order(const Visit& visit) const {
        HEXRELIEF_ROLLED
        for (unsigned k = 0; k < count_; ++k)
            visit(arrays_.segments[k], arrays_.segments[k].parent == largest_);
    }
    __device__ std::uint32_t first_pixel() const {
        return arrays_.segments[largest_].first;
    }                                                   // of the largest component
    __device__ unsigned area() const { return area_; }  // of the largest component
    __device__ unsigned outliers() const { return pixels_ - area_; }

  private:
    __device__ std::uint32_t index(int x, int y) const {
        return static_cast<std::uint32_t>(view_.index(x, y));
    }
    // Writes a row's segments.
    __device__ void put(const surface::PixelRun& run, unsigned number) const {
        std::uint32_t first = index(run.first, run.y);
        const auto put_one = [&](std::uint32_t end) {
            arrays_.segments[number] = {first, end, number};
            arrays_.areas[number] = 0;
            ++number;
            first = end;
        };
        HEXRELIEF_ROLLED
        for (int x = run.first; x < run.end; x += 32) {
            // the last pixels of segments
            unsigned lasts = words_.from(x, run.y).right & bits_between(0, run.end - 1 - x);
            if (x + 32 >= run.end) lasts |= 1u << (run.end - 1 - x);
            HEXRELIEF_ROLLED
            for (; lasts; lasts &= lasts - 1) put_one(index(x, run.y) + __ffs(static_cast<int>(lasts)));
        }
    }
    __device__ unsigned root(unsigned i) const {
        const auto parent = [&](unsigned k) {
            return static_cast<const volatile RowSegment*>(arrays_.segments)[k].parent;
        };
        HEXRELIEF_ROLLED
        for (unsigned above = parent(i); above != i; above = parent(i)) i = above;
        return i;
    }
    __device__ void join(unsigned i, unsigned j) const {
        HEXRELIEF_ROLLED
        for (;;) {
            i = root(i);
            j = root(j);
            const unsigned high = max(i, j);
            if (i == j || atomicCAS(&arrays_.segments[high].parent, high, min(i, j)) == high) return;
        }
    }
    // Calls visit(i, j) for connected segments of two rows that have no other row with pixels between them;
    // the segments are numbered from `above` and `below` on.
    template <typename Visit>
    __device__ void each_link(const surface::PixelRun& upper, unsigned above, const surface::PixelRun& lower,
                              unsigned below, bool is_free_bridge, const Visit& visit) const {
        const bool next = upper.y + 1 == lower.y;
        const unsigned upper_discontinuities = words_.from(upper.first, upper.y).right,
                       lower_discontinuities = words_.from(lower.first, lower.y).right;
        const auto number = [&](unsigned first, const surface::PixelRun& run, unsigned discontinuities,
                                int x) {
            const int before = x - run.first;
            return first + (before <= 32 ? __popc(discontinuities & bits_between(0, before))
                                         : words_.discontinuities_right(run.y, run.first, x));
        };
        unsigned corners = 0;  // free diagonals, and the bridge
        if (next) {
            HEXRELIEF_UNROLL
            for (int k = 0; k < 4; ++k)
                if (step::is_free_diagonal(words_.view(), k, upper, lower)) corners |= 1u << k;
        }
        if (is_free_bridge) corners |= 16;
        const int end = next ? min(upper.end, lower.end) : 0;
        unsigned linked = 0;  // bit 0: with the preceding columns
        HEXRELIEF_ROLLED
        for (int x = max(upper.first, lower.first);; x += 32) {
            unsigned columns = 0;  // columns at which the rows are connected, one for each pair of segments
            if (x < end) {
                const FlagWords::Bits own = words_.from(x, upper.y), others = words_.from(x, lower.y);
                const unsigned free = ~own.down & bits_between(0, end - x),
                               goes_on = free & ~own.right & ~others.right;
                columns = free & ~(goes_on << 1 | linked);
                linked = goes_on >> 31;
            }
            const bool last = x + 32 >= end;
            HEXRELIEF_ROLLED
            while (columns || (last && corners)) {
                step::Diagonal pair{};
                if (columns) {
                    pair.upper_x = pair.lower_x = x + __ffs(static_cast<int>(columns)) - 1;
                    columns &= columns - 1;
                } else {
                    const int k = __ffs(static_cast<int>(corners)) - 1;
                    const step::Bridge bridge = step::bridge_between(upper, lower);
                    pair = k < 4 ? step::diagonal_at(k, upper, lower)
                                 : step::Diagonal{bridge.upper_x, bridge.lower_x};
                    corners &= corners - 1;
                }
                visit(number(above, upper, upper_discontinuities, pair.upper_x),
                      number(below, lower, lower_discontinuities, pair.lower_x));
            }
            if (last) return;
        }
    }
    // True if the row does not touch the upper one and no discontinuity lies between them. The group checks
    // one path after the other.
    __device__ bool is_free_bridge(const GroupRow& row) const {
        const bool has_gap = row.own && row.has_upper && !surface::touch(row.upper, row.run);
        const step::Bridge bridge = step::bridge_between(row.upper, row.run);
        bool free = has_gap;
        HEXRELIEF_ROLLED
        for (unsigned left = group_.ballot(has_gap); __any_sync(kAllLanes, left != 0); left &= left - 1) {
            const unsigned source = left ? __ffs(static_cast<int>(left)) - 1 : 0;
            const int x0 = group_.from(bridge.upper_x, source), y0 = group_.from(row.upper.y, source),
                      x1 = group_.from(bridge.lower_x, source), y1 = group_.from(row.run.y, source);
            bool met = false;
            if (left) {
                const step::Way way = step::way_between_centres(x0, y0, x1, y1);
                const FlagWords::View view = words_.view();
                step::Crack crack;
                HEXRELIEF_ROLLED
                for (int k = static_cast<int>(group_.lane); k < way.steps; k += static_cast<int>(group_.size))
                    met |= step::steps_over(view, step::pixel_after(view, way, k),
                                            step::pixel_after(view, way, k + 1), crack);
            }
            met = group_.ballot(met) != 0;
            if (left && group_.lane == source && met) free = false;
        }
        return free;
    }
    // Calls visit(k) for the group's segments by all lanes of the warp together; k may exceed their number.
    template <typename Visit>
    __device__ void each_together(const Visit& visit) const {
        const unsigned rounds = most_of_lanes((count_ + group_.size - 1) / group_.size);
        HEXRELIEF_ROLLED
        for (unsigned round = 0; round < rounds; ++round) visit(round * group_.size + group_.lane);
    }
    // Makes all segments link directly to the first one of their component.
    __device__ void flatten() const {
        HEXRELIEF_ROLLED
        for (bool goes_on = true; __any_sync(kAllLanes, goes_on);) {
            goes_on = false;
            each_together([&](unsigned k) {
                unsigned parent = k, next = k;
                if (k < count_) {
                    parent = arrays_.segments[k].parent;
                    next = arrays_.segments[parent].parent;
                }
                __syncwarp();
                if (parent != next) {
                    arrays_.segments[k].parent = next;
                    goes_on = true;
                }
                __syncwarp();
            });
        }
    }
    // Adds up the areas of components at their first segments, and finds the largest, the
    // first of equal ones.
    __device__ void measure() {
        each([&](const RowSegment& s, bool) {
            const unsigned area = s.end - s.first;
            atomicAdd(&arrays_.areas[s.parent], area);
            pixels_ += area;
        });
        __syncwarp();
        unsigned long long best = 0;  // area in the upper half, segment in the lower half
        HEXRELIEF_ROLLED
        for (unsigned k = group_.lane; k < count_; k += group_.size)
            best = max(best, static_cast<unsigned long long>(arrays_.areas[k]) << 32 | (~0u - k));
        best = group_.joined(best, [](unsigned long long a, unsigned long long b) { return max(a, b); });
        pixels_ = group_.sum(pixels_);
        area_ = static_cast<unsigned>(best >> 32);
        largest_ = area_ ? ~0u - static_cast<unsigned>(best) : 0;
    }

    const step::PixelView& view_;
    const FlagWords& words_;
    const TriangleLanes& group_;
    ComponentArrays arrays_;
    unsigned count_ = 0, pixels_ = 0, largest_ = 0, area_ = 0;
};

}  // namespace hexrelief::cuda
