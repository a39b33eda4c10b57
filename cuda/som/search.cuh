// The competition on the device: the best matching unit of a point, found by a warp or by a group of
// its lanes. Included by train_large.cu and train_small.cu. Data that other blocks write is read past
// the L1 cache (__ldcg).
#pragma once

#include "cuda/som/level.h"
#include "mesher/som/best_matching_unit_step.h"
#include "mesher/som/learning_step.h"

namespace hexrelief::cuda {

inline constexpr unsigned kAllLanes = 0xFFFFFFFFu;

// Returns a candidate as one integer. Squared distances are non-negative, so their bits have their order, and
// ties go to the lowest index.
__device__ __forceinline__ std::uint64_t candidate_key(float squared_distance, std::uint32_t neuron) {
    return static_cast<std::uint64_t>(__float_as_uint(squared_distance)) << 32 | neuron;
}

__device__ __forceinline__ float key_distance(std::uint64_t key) {
    return __uint_as_float(static_cast<std::uint32_t>(key >> 32));
}

// Returns the least key of a group of kLanes lanes.
template <int kLanes>
__device__ __forceinline__ std::uint64_t least_of_group(std::uint64_t key) {
#if __CUDA_ARCH__ >= 800
    constexpr bool kInHardware = kLanes == 32;
#else
    constexpr bool kInHardware = false;
#endif
    if constexpr (kInHardware) {  // two reductions instead of ten shuffles
#if __CUDA_ARCH__ >= 800
        const std::uint32_t high = static_cast<std::uint32_t>(key >> 32);
        const std::uint32_t least = __reduce_min_sync(kAllLanes, high);
        const std::uint32_t low = high == least ? static_cast<std::uint32_t>(key) : 0xFFFFFFFFu;
        key = static_cast<std::uint64_t>(least) << 32 | __reduce_min_sync(kAllLanes, low);
#endif
    } else {
        for (int step = kLanes / 2; step > 0; step /= 2) {
            const std::uint64_t other = __shfl_xor_sync(kAllLanes, key, step, kLanes);
            key = other < key ? other : key;
        }
    }
    return key;
}

// Adds 1 to counts[cell] for each calling lane and returns the lane's rank in its cell. Lanes with the same
// cell, as most neighbouring neurons have, share one atomic operation. All lanes of the warp must call; those
// with cell < 0 add nothing.
__device__ __forceinline__ std::uint32_t count_in_cell(std::uint32_t* counts, int cell) {
    const unsigned same = __match_any_sync(kAllLanes, cell);
    const int lane = threadIdx.x % 32, leader = __ffs(same) - 1;
    std::uint32_t base = 0;
    if (lane == leader && cell >= 0)
        base = atomicAdd(&counts[cell], static_cast<std::uint32_t>(__popc(same)));
    return __shfl_sync(kAllLanes, base, leader) + __popc(same & ((1u << lane) - 1));
}

// Reads a neuron in a single access.
__device__ __forceinline__ SortedNeuron load_neuron(const SortedNeuron* at) {
    std::uint32_t x, y, id, batch;
    asm volatile("ld.relaxed.gpu.global.v4.u32 {%0, %1, %2, %3}, [%4];"
                 : "=r"(x), "=r"(y), "=r"(id), "=r"(batch)
                 : "l"(at));
    return {__uint_as_float(x), __uint_as_float(y), id, batch};
}

// Writes a neuron in a single access.
__device__ __forceinline__ void store_neuron(SortedNeuron* at, float x, float y, std::uint32_t id,
                                             std::uint32_t batch) {
    asm volatile("st.relaxed.gpu.global.v4.u32 [%0], {%1, %2, %3, %4};" ::"l"(at), "r"(__float_as_uint(x)),
                 "r"(__float_as_uint(y)), "r"(id), "r"(batch)
                 : "memory");
}

// The neurons of the cells as a search reads them: the bounds of the cells' ranges, and the sorted neurons.
struct GlobalCells {
    const std::uint32_t* begin;
    const SortedNeuron* sorted;
    __device__ std::uint32_t bound(int i) const { return __ldcg(&begin[i]); }
    __device__ const SortedNeuron* neuron(std::uint32_t i) const { return &sorted[i]; }
    __device__ std::uint32_t id(const SortedNeuron& at) const { return at.id; }
};

// A point, px, in cell (cx, cy), which is compared with the positions at the start of a batch.
struct PointQuery {
    float px, py;
    int cx, cy;
    std::uint32_t batch;
};

// Searches the rings of one point from ring 2 on, with a whole warp: few searches get here, but all others
// wait for them. First each lane takes a cell, then each lane takes a neuron of these cells, with several
// loads in flight. All lanes pass the same query and candidate. Returns the key of the best candidate.
template <typename Cells>
__device__ __forceinline__ std::uint64_t far_rings(const LevelView& level, const Cells& cells,
                                                   const PointQuery& query, std::uint64_t best) {
    const step::CellGrid& grid = level.grid;
    const auto [px, py, cx, cy, batch] = query;
    const int limit = step::ring_limit(grid, level.ssr), pitch = grid.columns + 1, lane = threadIdx.x % 32;
    for (int ring = 2; ring <= limit; ++ring) {
        const float reach = key_distance(best);
        if (step::ring_distance(grid, cx, cy, ring, px, py) > reach) break;
        for (int k0 = 0; k0 < 8 * ring; k0 += 32) {
            std::uint32_t begin = 0, count = 0;
            int u, v;
            step::ring_cell(ring, k0 + lane, u, v);
            u += cx;
            v += cy;
            if (k0 + lane < 8 * ring && u >= 0 && u < grid.columns && v >= 0 && v < grid.rows &&
                !(step::cell_distance(grid, u, v, px, py) > reach)) {
                begin = cells.bound(v * pitch + u);
                count = cells.bound(v * pitch + u + 1) - begin;
            }
            std::uint32_t upto = count;
            for (int step = 1; step < 32; step *= 2) {
                const std::uint32_t before = __shfl_up_sync(kAllLanes, upto, step);
                if (lane >= step) upto += before;
            }
            const std::uint32_t total = __shfl_sync(kAllLanes, upto, 31);
            constexpr int kAtOnce = 2;
            for (std::uint32_t base = 0; base < total; base += 32 * kAtOnce) {
                SortedNeuron at[kAtOnce];
                std::uint32_t index[kAtOnce];
#pragma unroll
                for (int j = 0; j < kAtOnce; ++j) {
                    // the last one again, beyond the end
                    const std::uint32_t k = min(base + lane + 32 * j, total - 1);
                    int owner = 0;  // the lane whose cell holds neuron k
                    for (int step = 16; step > 0; step /= 2)
                        if (__shfl_sync(kAllLanes, upto, owner + step - 1) <= k) owner += step;
                    index[j] = __shfl_sync(kAllLanes, begin + count - upto, owner) + k;
                    at[j] = load_neuron(cells.neuron(index[j]));
                }
#pragma unroll
                for (int j = 0; j < kAtOnce; ++j) {
                    while (at[j].batch != batch) at[j] = load_neuron(cells.neuron(index[j]));
                    const float dx = at[j].x - px, dy = at[j].y - py;
                    const std::uint64_t key = candidate_key(dx * dx + dy * dy, cells.id(at[j]));
                    best = key < best ? key : best;
                }
            }
        }
        best = least_of_group<32>(best);
    }
    return best;
}

// Column or row of the cell at a coordinate in half px.
__device__ __forceinline__ int cell_of_half_px(const LevelView& level, std::uint32_t coordinate) {
    return static_cast<int>(__umulhi(coordinate, level.cell_factor));
}

// step::spiral_search() by a group of kLanes lanes, on the positions at the start of `batch`. Each row of
// cells is one range of sorted neurons, so the point's cell and ring 1 are three ranges, whose bounds are
// loaded at once. Rings further out are searched by the whole warp. Inactive groups take part in the
// votes of their warp.
template <int kLanes, typename Cells>
class GroupSearch {
  public:
    // point: x | y << 16 in half px; lane: index within the group.
    __device__ __forceinline__ GroupSearch(const LevelView& level, const Cells& cells, std::uint32_t point,
                                           std::uint32_t batch, bool active, int lane)
        : level_(level),
          cells_(cells),
          grid_(level.grid),
          px_(static_cast<float>(point & 0xFFFFu) * 0.5f),
          py_(static_cast<float>(point >> 16) * 0.5f),
          cx_(cell_of_half_px(level, point & 0xFFFFu)),
          cy_(cell_of_half_px(level, point >> 16)),
          lane_(lane),
          batch_(batch),
          active_(active),
          best_(candidate_key(step::Candidate{}.squared_distance, step::Candidate{}.neuron)) {}

    // Returns the best matching unit, or step::kNoNeuron.
    __device__ __forceinline__ std::uint32_t run() {
        load_bounds();
        const std::uint32_t own_begin = bound(1, 1), own_end = bound(1, 2);
        // Squared distances to the neighbouring cells: all terms are multiples of a quarter pixel, so these
        // are exactly those of step::cell_distance().
        left_ = px_ - static_cast<float>(cx_ * grid_.co);
        right_ = static_cast<float>((cx_ + 1) * grid_.co) - px_;
        up_ = py_ - static_cast<float>(cy_ * grid_.co);
        down_ = static_cast<float>((cy_ + 1) * grid_.co) - py_;
        if constexpr (kLanes == 32)
            if (search_at_once(own_begin, own_end)) return static_cast<std::uint32_t>(best_);
        if (active_) consider(own_end - own_begin, [&](std::uint32_t k) { return own_begin + k; });
        best_ = least_of_group<kLanes>(best_);
        reach_ = key_distance(best_);
        const bool searching = reaches_ring_1();
        if (__any_sync(kAllLanes, searching)) search_ring_1(searching, own_begin, own_end);
        search_far_rings(searching);
        return static_cast<std::uint32_t>(best_);
    }

  private:
    static constexpr int kAtOnce = 4;  // loads that a lane has in flight

    // Loads the bounds of the cells cx - 1, cx, cx + 1 in rows cy - 1, cy, cy + 1: four numbers per row.
    __device__ __forceinline__ void load_bounds() {
        const int pitch = grid_.columns + 1;
#pragma unroll
        for (int k = 0; k * kLanes < 12; ++k) {
            const int j = lane_ + k * kLanes, v = cy_ - 1 + j / 4,
                      u = min(max(cx_ - 1 + j % 4, 0), grid_.columns);
            if (active_ && j < 12 && v >= 0 && v < grid_.rows) bounds_[k] = cells_.bound(v * pitch + u);
        }
    }
    __device__ __forceinline__ std::uint32_t bound(int row, int j) const {
        const int k = row * 4 + j;
        return __shfl_sync(kAllLanes, bounds_[k / kLanes], k % kLanes, kLanes);
    }

    __device__ __forceinline__ bool reaches_ring_1() const {
        return active_ && !(step::ring_distance(grid_, cx_, cy_, 1, px_, py_) > reach_);
    }

    __device__ __forceinline__ void compare(const SortedNeuron& at) {
        const float dx = at.x - px_, dy = at.y - py_;
        const std::uint64_t key = candidate_key(dx * dx + dy * dy, cells_.id(at));
        best_ = key < best_ ? key : best_;
    }

    // Compares the neurons index(k) for k in [0, count).
    template <typename Index>
    __device__ __forceinline__ void consider(std::uint32_t count, const Index& index) {
        for (std::uint32_t k0 = lane_; k0 < count; k0 += kAtOnce * kLanes) {
            SortedNeuron at[kAtOnce];
#pragma unroll
            for (int j = 0; j < kAtOnce; ++j) {
                // Beyond the end the last one is loaded again.
                const std::uint32_t i = index(min(k0 + j * kLanes, count - 1));
                at[j] = load_neuron(cells_.neuron(i));
            }
#pragma unroll
            for (int j = 0; j < kAtOnce; ++j)
                while (at[j].batch != batch_)
                    at[j] = load_neuron(cells_.neuron(index(min(k0 + j * kLanes, count - 1))));
#pragma unroll
            for (int j = 0; j < kAtOnce; ++j) compare(at[j]);
        }
    }

    // Searches the point's cell and ring 1 at once, which a warp has enough lanes for; neurons of cells
    // further away than the nearest neuron of the point's cell are skipped afterwards. Returns false, and
    // does nothing, if there are too many neurons.
    __device__ __forceinline__ bool search_at_once(std::uint32_t own_begin, std::uint32_t own_end) {
        const std::uint32_t begin0 = bound(0, 0), begin2 = bound(2, 0), begin1 = bound(1, 0);
        const std::uint32_t upto0 = bound(0, 3) - begin0, upto1 = upto0 + bound(2, 3) - begin2,
                            upto2 = upto1 + bound(1, 3) - begin1;
        const std::uint32_t second0 = bound(0, 1), third0 = bound(0, 2), second2 = bound(2, 1),
                            third2 = bound(2, 2);
        if (upto2 > kAtOnce * kLanes) return false;
        SortedNeuron at[kAtOnce];
        float across[kAtOnce];  // squared distance to the neuron's cell; below 0 = the point's own cell
        const auto index = [&](std::uint32_t k) {
            return k < upto0 ? begin0 + k : k < upto1 ? begin2 + (k - upto0) : begin1 + (k - upto1);
        };
        const float west = cx_ > 0 ? left_ * left_ : 0.0f, east = right_ * right_;
#pragma unroll
        for (int j = 0; j < kAtOnce; ++j)
            if (static_cast<std::uint32_t>(lane_ + j * kLanes) < upto2)
                at[j] = load_neuron(cells_.neuron(index(lane_ + j * kLanes)));
#pragma unroll
        for (int j = 0; j < kAtOnce; ++j) {
            const std::uint32_t k = lane_ + j * kLanes, row = k < upto0 ? 0 : k < upto1 ? 2 : 1;
            const std::uint32_t i = index(k);
            const std::uint32_t second = row == 0 ? second0 : row == 2 ? second2 : own_begin;
            const std::uint32_t third = row == 0 ? third0 : row == 2 ? third2 : own_end;
            const float vertical = row == 0 ? up_ * up_ : row == 2 ? down_ * down_ : 0.0f;
            across[j] = vertical + (i < second ? west : i < third ? 0.0f : east);
            if (row == 1 && i >= second && i < third) across[j] = -1.0f;
            if (k >= upto2) continue;
            while (at[j].batch != batch_) at[j] = load_neuron(cells_.neuron(i));
            if (across[j] < 0.0f) compare(at[j]);
        }
        best_ = least_of_group<kLanes>(best_);
        reach_ = key_distance(best_);
        if (!reaches_ring_1()) return true;
#pragma unroll
        for (int j = 0; j < kAtOnce; ++j)
            if (static_cast<std::uint32_t>(lane_ + j * kLanes) < upto2 && !(across[j] < 0.0f) &&
                !(across[j] > reach_))
                compare(at[j]);
        best_ = least_of_group<kLanes>(best_);
        if (active_) best_ = far_rings(level_, cells_, {px_, py_, cx_, cy_, batch_}, best_);
        return true;
    }

    // Searches the cells of ring 1 that are within reach. searching: true if the group's
    // point reaches the ring.
    __device__ __forceinline__ void search_ring_1(bool searching, std::uint32_t own_begin,
                                                  std::uint32_t own_end) {
        const auto range_of_row = [&](int row, float across, std::uint32_t& begin, std::uint32_t& count) {
            const bool west = cx_ > 0 && !(left_ * left_ + across > reach_);
            const bool east = cx_ + 1 < grid_.columns && !(right_ * right_ + across > reach_);
            const bool some = searching && !(across > reach_) && cy_ + row > 0 && cy_ + row <= grid_.rows;
            const std::uint32_t first = bound(row, 0), second = bound(row, 1), third = bound(row, 2),
                                fourth = bound(row, 3);
            begin = west ? first : second;
            count = some ? (east ? fourth : third) - begin : 0u;
        };
        std::uint32_t begin0, begin1, begin2, count0, count1, count2;
        range_of_row(0, up_ * up_, begin0, count0);
        range_of_row(2, down_ * down_, begin1, count1);
        // of the point's own row only the cells to the left and to the right
        range_of_row(1, 0.0f, begin2, count2);
        const std::uint32_t west2 = count2 ? own_begin - begin2 : 0u;
        if (count2) count2 -= own_end - own_begin;
        const std::uint32_t upto1 = count0 + count1, upto2 = upto1 + west2;
        consider(upto1 + count2, [&](std::uint32_t k) {
            return k < count0  ? begin0 + k
                   : k < upto1 ? begin1 + (k - count0)
                   : k < upto2 ? begin2 + (k - upto1)
                               : own_end + (k - upto2);
        });
        best_ = least_of_group<kLanes>(best_);
    }

    // Searches the rings further out with the whole warp, for one group's point after the other.
    __device__ __forceinline__ void search_far_rings(bool searching) {
        const bool goes_on = searching && lane_ == 0 && step::ring_limit(grid_, level_.ssr) > 1 &&
                             !(step::ring_distance(grid_, cx_, cy_, 2, px_, py_) > key_distance(best_));
        unsigned waiting = __ballot_sync(kAllLanes, goes_on);
        for (; waiting; waiting &= waiting - 1) {
            const int leader = __ffs(waiting) - 1;
            const std::uint64_t found =
                far_rings(level_, cells_,
                          {__shfl_sync(kAllLanes, px_, leader), __shfl_sync(kAllLanes, py_, leader),
                           __shfl_sync(kAllLanes, cx_, leader), __shfl_sync(kAllLanes, cy_, leader), batch_},
                          __shfl_sync(kAllLanes, best_, leader));
            if (static_cast<int>(threadIdx.x % 32) / kLanes == leader / kLanes) best_ = found;
        }
    }

    const LevelView& level_;
    const Cells& cells_;
    const step::CellGrid& grid_;
    const float px_, py_;
    const int cx_, cy_, lane_;
    const std::uint32_t batch_;
    const bool active_;
    std::uint64_t best_;
    std::uint32_t bounds_[(12 + kLanes - 1) / kLanes] = {};
    float left_, right_, up_, down_;  // px from the point to the sides of its cell
    float reach_;                     // squared distance of the best candidate in the point's own cell
};

// A patch: the neurons of one warp. A row of a patch is one byte of the mask.
inline constexpr int kPatchColumns = 8, kPatchRows = 4;

// Adds one unit to the sums of the neuron at axial (q, row).
__device__ __forceinline__ void accumulate_unit(const uint4& unit, const uint2* tables, int q, int row,
                                                step::LearningSums& sums) {
    const int dq = static_cast<std::int16_t>(unit.x & 0xFFFFu) - q, dr = static_cast<int>(unit.x >> 16) - row;
    const int distance = max(max(abs(dq), abs(dr)), abs(dq + dr));
    const uint2 table = tables[min(distance, kTableWidth - 1)];
    sums.gain += table.x * unit.y;
    sums.x += table.x * unit.z;
    sums.y += table.x * unit.w;
    sums.decay += table.y * unit.y;
}

}  // namespace hexrelief::cuda
