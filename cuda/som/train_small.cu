#include <cub/block/block_scan.cuh>

#include "cuda/common/check.h"
#include "cuda/som/search.cuh"
#include "cuda/som/train_small.h"

namespace hexrelief::cuda {
namespace {

constexpr int kBlock = 640, kWarps = kBlock / 32;
constexpr int kMostNeurons = 16384, kMostCells = 4096, kMostPoints = 1024;
constexpr std::uint32_t kNoUnit = 0x7FFF0000u;  // position of an empty record: a row beyond all others
static_assert(kWarps >= kMostBatch);

struct Scratch {  // a block's shared memory; the cell lists follow it
    uint4 units[kWarps][64];
    step::Target targets[2][kWarps][32];  // two sets: one is read while the other is written
    struct Batch {                        // what a batch is known to need before it begins
        uint2 tables[kMostBatch][kTableWidth];
        int radius[kMostBatch];
        uint2 points[kMostBatch];     // of each iteration: drawn, and with empty records
        std::uint32_t first[kWarps];  // the first point that each warp looks for
    } batches[2];                     // this one and the next
};

// A block's own cell lists: the neurons sorted by cell.
struct BlockCells {
    std::uint32_t* begin;    // columns + 1 bounds a row of cells
    std::uint32_t* sorting;  // of each neuron: cell << 16 | rank in it
    std::uint16_t* ids;
    const SortedNeuron* neurons;  // by neuron
    __device__ std::uint32_t bound(int i) const { return begin[i]; }
    __device__ const SortedNeuron* neuron(std::uint32_t i) const { return &neurons[ids[i]]; }
    // the upper half is the bound of the neuron's cell, where a refresh comes next
    __device__ std::uint32_t id(const SortedNeuron& at) const { return at.id & 0xFFFFu; }
};

std::size_t shared_bytes(const LevelView& level) {
    const std::size_t neurons = static_cast<std::size_t>(level.lattice.columns) * level.lattice.rows;
    const std::size_t bounds = static_cast<std::size_t>(level.grid.columns + 1) * level.grid.rows;
    return sizeof(Scratch) + (bounds + neurons) * sizeof(std::uint32_t) + neurons * sizeof(std::uint16_t);
}

// Index of the bound of a position's cell. Computed once, where the neuron learns, and not again by every
// block.
__device__ __forceinline__ std::uint32_t bound_of(const LevelView& level, float x, float y) {
    const int cell = step::cell_of(level.grid, x, y);
    return static_cast<std::uint32_t>(cell + cell / level.grid.columns);
}

// The paper's cell refresh (section 4.2), by every block for itself, so that no block waits for another's
// lists.
__device__ void refresh_cells(const LevelView& level, const BlockCells& cells, std::uint32_t batch) {
    using Scan = cub::BlockScan<std::uint32_t, kBlock>;
    __shared__ typename Scan::TempStorage scan_storage;
    const int neurons = level.lattice.columns * level.lattice.rows, pitch = level.grid.columns + 1;
    const int bounds = pitch * level.grid.rows, lane = threadIdx.x % 32;
    for (int c = threadIdx.x; c < bounds; c += kBlock) cells.begin[c] = 0;
    __syncthreads();
    constexpr int kAtOnce = 12;  // loads under way a thread
    for (int i0 = threadIdx.x - lane; i0 < neurons; i0 += kAtOnce * kBlock) {
        SortedNeuron at[kAtOnce];
#pragma unroll
        for (int k = 0; k < kAtOnce; ++k)
            at[k] = load_neuron(&cells.neurons[min(i0 + lane + k * kBlock, neurons - 1)]);
#pragma unroll
        for (int k = 0; k < kAtOnce; ++k) {
            const int i = i0 + lane + k * kBlock;
            if (i0 + k * kBlock >= neurons) break;
            while (at[k].batch != batch) at[k] = load_neuron(&cells.neurons[min(i, neurons - 1)]);
            const int bound = i < neurons ? static_cast<int>(at[k].id >> 16) : -1;
            const std::uint32_t rank = count_in_cell(cells.begin, bound);
            if (i < neurons) cells.sorting[i] = static_cast<std::uint32_t>(bound) << 16 | rank;
        }
    }
    __syncthreads();
    std::uint32_t before = 0;
    for (int first = 0; first < bounds; first += kBlock) {
        const int c = first + threadIdx.x;
        std::uint32_t start, total;
        Scan(scan_storage).ExclusiveSum(c < bounds ? cells.begin[c] : 0u, start, total);
        if (c < bounds) cells.begin[c] = before + start;
        before += total;
        __syncthreads();
    }
    for (int i = threadIdx.x; i < neurons; i += kBlock)
        cells.ids[cells.begin[cells.sorting[i] >> 16] + (cells.sorting[i] & 0xFFFFu)] =
            static_cast<std::uint16_t>(i);
    __syncthreads();
}

__device__ __forceinline__ uint4 load_record(const uint4* at) {
    uint4 r;
    asm volatile("ld.relaxed.gpu.global.v4.u32 {%0, %1, %2, %3}, [%4];"
                 : "=r"(r.x), "=r"(r.y), "=r"(r.z), "=r"(r.w)
                 : "l"(at));
    return r;
}

__device__ __forceinline__ void store_record(uint4* at, const uint4& r) {
    asm volatile("st.relaxed.gpu.global.v4.u32 [%0], {%1, %2, %3, %4};" ::"l"(at), "r"(r.x), "r"(r.y),
                 "r"(r.z), "r"(r.w)
                 : "memory");
}

// What one warp computes: the learning sums of a patch of neurons over the records of one iteration.
struct SumTask {
    const uint4* records;
    std::uint32_t count, batch;
    int2 patch;  // its column and row, in patches
    int radius;
    const uint2* tables;  // gain and decay of each distance
    uint4* scratch;       // 64 units
};

// The sums of the lane's neuron. Waits for the records of the task's batch; lists those within reach of the
// patch, and all lanes add up all that are listed.
__device__ __forceinline__ step::LearningSums sum_of_records(const LevelView& level, const SumTask& task,
                                                             int lane) {
    const int row = task.patch.y * kPatchRows + lane / kPatchColumns;
    const int q = step::axial_q(task.patch.x * kPatchColumns + lane % kPatchColumns, row);
    const int top = task.patch.y * kPatchRows - task.radius, height = kPatchRows + 2 * task.radius;
    const int left = task.patch.x * kPatchColumns - task.radius - 1,
              width = kPatchColumns + 2 * task.radius + 2;
    step::LearningSums sums;
    int listed = 0;
    const auto add_all = [&] {
        __syncwarp();
#pragma unroll 4
        for (int k = 0; k < listed; ++k) accumulate_unit(task.scratch[k], task.tables, q, row, sums);
        __syncwarp();
        listed = 0;
    };
    constexpr int kAtOnce = 6;  // loads under way a lane
    for (std::uint32_t base = 0; base < task.count; base += 32 * kAtOnce) {
        uint4 record[kAtOnce];
#pragma unroll
        for (int k = 0; k < kAtOnce; ++k)
            if (base + k * 32 < task.count)
                record[k] = load_record(&task.records[min(base + k * 32 + lane, task.count - 1)]);
#pragma unroll
        for (int k = 0; k < kAtOnce; ++k) {
            if (base + k * 32 >= task.count) break;
            const std::uint32_t i = base + k * 32 + lane;
            while (record[k].w != task.batch) record[k] = load_record(&task.records[min(i, task.count - 1)]);
            const int unit_row = record[k].x >> 16;
            const int unit_column = static_cast<std::int16_t>(record[k].x & 0xFFFFu) + unit_row / 2;
            const bool keep = i < task.count &&
                              static_cast<unsigned>(unit_row - top) < static_cast<unsigned>(height) &&
                              static_cast<unsigned>(unit_column - left) < static_cast<unsigned>(width);
            const unsigned kept = __ballot_sync(kAllLanes, keep);
            if (listed + __popc(kept) > 64) add_all();
            if (keep)
                task.scratch[listed + __popc(kept & ((1u << lane) - 1))] = {record[k].x, 1u, record[k].y,
                                                                            record[k].z};
            listed += __popc(kept);
        }
    }
    add_all();
    return sums;
}

// Iterations [first, end) in batches, as train_kernel in train_large.cu, but no block ever waits for all
// others. Each position and each unit is a record that carries the number of its batch; a reader that finds
// the batch before reads again. A patch learns only when it has read every record of its batch. Therefore
// - no position is overwritten before all competitions of its batch have read it;
// - no record is overwritten (there are two sets, used alternately) before all patches have read it. For this
//   each block writes at least one record a batch, and none of the next batch before its patches are done.
template <int kLanes>
__global__ void __launch_bounds__(kBlock, 1)
    train_small_kernel(LevelView level, SmallView view, int first, int end, int crr, int prr, int batch) {
    extern __shared__ uint4 memory[];
    Scratch& scratch = *reinterpret_cast<Scratch*>(memory);
    const int columns = level.lattice.columns, rows = level.lattice.rows, neurons = columns * rows;
    std::uint32_t* const begin = reinterpret_cast<std::uint32_t*>(&scratch + 1);
    std::uint32_t* const sorting = begin + (level.grid.columns + 1) * level.grid.rows;
    const BlockCells cells{begin, sorting, reinterpret_cast<std::uint16_t*>(sorting + neurons), level.sorted};
    const int lane = threadIdx.x % 32, block_warp = threadIdx.x / 32;
    // warps of all blocks in turn, so that work spreads evenly over the multiprocessors
    const int warp = block_warp * gridDim.x + blockIdx.x, warps = gridDim.x * kWarps;
    const int patches_x = (columns + kPatchColumns - 1) / kPatchColumns;
    const int patches = patches_x * ((rows + kPatchRows - 1) / kPatchRows);
    constexpr int kGroups = 32 / kLanes;  // of a warp
    // Task `task` of a batch as iteration and point; false beyond the last.
    const auto find_task = [&](const Scratch::Batch& next, int length, std::uint32_t task, int& t,
                               std::uint32_t& k) {
        t = 0;
        k = task;
        while (t < length && k >= next.points[t].y) k -= next.points[t++].y;
        return t < length;
    };
    const auto point_of = [&](int from, int t, std::uint32_t k) {
        return level.points[static_cast<std::size_t>(from - first + t) * level.point_capacity + k];
    };
    // By the last warps of a block, which are the least likely to have a patch. The last iteration of a batch
    // is filled up with empty records until there is one for each block's first group.
    const auto prepare = [&](int from, int number) {
        Scratch::Batch& next = scratch.batches[number & 1];
        const int length = step::batch_end(from, end, crr, prr) - from;
        if (block_warp == kWarps - 1) {
            const std::uint32_t own = lane < length ? level.point_count[from + lane - first] : 0;
            std::uint32_t all = own, least = gridDim.x * kGroups;
            for (int step = 16; step > 0; step /= 2) all += __shfl_xor_sync(kAllLanes, all, step);
            if (lane < length)
                next.points[lane] = {own, lane == length - 1 && all < least ? own + least - all : own};
            __syncwarp();
            int t;
            std::uint32_t k;
            if (kGroups == 1 && lane < kWarps &&
                find_task(next, length, lane * gridDim.x + blockIdx.x, t, k) && k < next.points[t].x)
                next.first[lane] = point_of(from, t, k);
        }
        for (int k = kWarps - 2 - block_warp; k >= 0 && k < length; k += kWarps - 1) {
            const int t = from + k;
            next.tables[k][lane] = {level.gain[t * kTableWidth + lane], level.decay[t * kTableWidth + lane]};
            if (lane == 0) next.radius[k] = level.radius[t];
        }
    };

    for (int i = blockIdx.x * kBlock + threadIdx.x; i < neurons; i += gridDim.x * kBlock)
        store_neuron(&level.sorted[i], level.x[i], level.y[i],
                     i | bound_of(level, level.x[i], level.y[i]) << 16, batch);
    prepare(first, batch);
    __syncthreads();
    for (int from = first, to; from < end; from = to, ++batch) {
        to = step::batch_end(from, end, crr, prr);
        const int length = to - from;
        if (from % crr == 0) refresh_cells(level, cells, batch);
        const Scratch::Batch& now = scratch.batches[batch & 1];
        uint4* const records = view.records + static_cast<std::size_t>(batch & 1) * prr * view.capacity;
        std::uint32_t tasks = 0;
        for (int k = 0; k < length; ++k) tasks += now.points[k].y;
        for (std::uint32_t base = warp * kGroups; base < tasks; base += warps * kGroups) {
            int t;
            std::uint32_t k;
            const bool task = find_task(now, length, base + lane / kLanes, t, k);
            const bool active = task && k < now.points[t].x;
            const std::uint32_t point = !active ? 0
                                        : kGroups == 1 && base == static_cast<std::uint32_t>(warp)
                                            ? now.first[block_warp]
                                            : point_of(from, t, k);
            const std::uint32_t neuron =
                search_by_group<kLanes>(level, cells, point, batch, active, lane % kLanes);
            if (!task || lane % kLanes != 0) continue;
            std::uint32_t position = kNoUnit;
            if (active && neuron != step::kNoNeuron) {
                const int row = neuron / columns, column = neuron % columns;
                position = (static_cast<std::uint32_t>(step::axial_q(column, row)) & 0xFFFFu) |
                           static_cast<std::uint32_t>(row) << 16;
            }
            store_record(&records[t * view.capacity + k],
                         {position, point & 0xFFFFu, point >> 16, static_cast<std::uint32_t>(batch)});
        }
        if (to < end) prepare(to, batch + 1);
        const int groups = kWarps / length, group = block_warp / length, k = block_warp % length;
        for (int round = 0; round * groups * static_cast<int>(gridDim.x) < patches; ++round) {
            const int patch = (round * groups + group) * gridDim.x + blockIdx.x;
            const bool working = group < groups && patch < patches;
            const int patch_column = patch % patches_x, patch_row = patch / patches_x;
            const int column = patch_column * kPatchColumns + lane % kPatchColumns,
                      row = patch_row * kPatchRows + lane / kPatchColumns, i = row * columns + column;
            const bool inside = working && column < columns && row < rows;
            SortedNeuron at = load_neuron(&level.sorted[inside ? i : 0]);
            if (working) {
                const step::LearningSums own = sum_of_records(
                    level,
                    {records + k * view.capacity, now.points[k].y, static_cast<std::uint32_t>(batch),
                     int2{patch_column, patch_row}, now.radius[k], now.tables[k], scratch.units[block_warp]},
                    lane);
                scratch.targets[round & 1][block_warp][lane] = step::target_of(own, at.x, at.y);
            }
            __syncthreads();
            if (!inside || k != 0) continue;
            const step::Border border = border_of(level);
            const bool rests = step::rests(border, column);
            for (int t = 0; t < length; ++t) {
                const step::Target target = scratch.targets[round & 1][block_warp + t][lane];
                if (target.share == 0.0f || rests) continue;
                step::learn(target, level.extent_x, level.extent_y, at.x, at.y);
                if (level.pinned) step::pin_to_border(border, column, row, at.x, at.y);
            }
            store_neuron(&level.sorted[i], at.x, at.y,
                         to % crr == 0 ? i | bound_of(level, at.x, at.y) << 16 : i, batch + 1);
            if (to < end) continue;
            level.x[i] = at.x;
            level.y[i] = at.y;
        }
        __syncthreads();
    }
}

using Kernel = void (*)(LevelView, SmallView, int, int, int, int, int);

int blocks_of(const Launch& launch, const LevelView& level) {
    const int patches = (level.lattice.columns + kPatchColumns - 1) / kPatchColumns *
                        ((level.lattice.rows + kPatchRows - 1) / kPatchRows);
    return std::min(launch.multiprocessors, patches);  // each block has a patch, so it waits for all records
}

std::uint32_t record_capacity(const Launch& launch, const LevelView& level) {
    return level.point_capacity + static_cast<std::uint32_t>(blocks_of(launch, level)) * 4;
}

}  // namespace

bool is_small(const LevelView& level) {
    return static_cast<long long>(level.lattice.columns) * level.lattice.rows <= kMostNeurons &&
           static_cast<long long>(level.grid.columns + 1) * level.grid.rows <= kMostCells &&
           level.point_capacity <= kMostPoints;
}

std::size_t small_records(const Launch& launch, const LevelView& level, int longest) {
    return static_cast<std::size_t>(2) * longest * record_capacity(launch, level);
}

void clear_small(const Launch& launch, const LevelView& level, uint4* records, int longest) {
    const std::size_t neurons = static_cast<std::size_t>(level.lattice.columns) * level.lattice.rows;
    // no batch's number
    check(cudaMemsetAsync(records, 0xFF, small_records(launch, level, longest) * sizeof *records,
                          launch.stream),
          "clearing the records");
    check(cudaMemsetAsync(level.sorted, 0xFF, neurons * sizeof *level.sorted, launch.stream),
          "clearing the positions");
}

void train_small(const Launch& launch, const LevelView& level, uint4* records, const IterationRange& range) {
    int first = range.first, crr = range.crr, prr = range.prr;
    // batches are numbered from their first iteration on, so that no number comes twice in a level
    int end = first + range.count, blocks = blocks_of(launch, level), batch = first;
    const bool warp_each = static_cast<long long>(level.point_capacity) * prr <= blocks * kWarps * 4;
    const auto kernel = reinterpret_cast<const void*>(warp_each ? Kernel(train_small_kernel<32>)
                                                                : Kernel(train_small_kernel<8>));
    const std::size_t bytes = shared_bytes(level);
    check(cudaFuncSetAttribute(kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, static_cast<int>(bytes)),
          "allowing shared memory");
    LevelView copy = level;
    SmallView view{records, record_capacity(launch, level)};
    void* arguments[] = {&copy, &view, &first, &end, &crr, &prr, &batch};
    check(cudaLaunchCooperativeKernel(kernel, dim3(blocks), dim3(kBlock), arguments, bytes, launch.stream),
          "training");
}

}  // namespace hexrelief::cuda
