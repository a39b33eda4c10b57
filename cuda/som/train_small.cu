#include <cub/block/block_scan.cuh>

#include "cuda/common/check.h"
#include "cuda/som/level.h"
#include "cuda/som/search.cuh"

namespace hexrelief::cuda {
namespace {

constexpr int kBlock = 640, kWarps = kBlock / 32;
constexpr int kMostNeurons = 16384, kMostCells = 4096, kMostPoints = 1024;
constexpr std::uint32_t kNoUnit = 0x7FFF0000u;  // position of an empty record: a row beyond all others
static_assert(kWarps >= som::kMostBatch);

struct Scratch {  // A block's shared memory; the cell lists follow it.
    uint4 units[kWarps][64];
    step::Target targets[2][kWarps][32];  // two sets: one is read while the other is written
    struct Batch {                        // Data that a batch needs and that is known before it begins.
        uint2 tables[som::kMostBatch][kTableWidth];
        int radius[som::kMostBatch];
        uint2 points[som::kMostBatch];  // per iteration: number of points drawn, and the same with empty
                                        // records
        std::uint32_t first[kWarps];    // the first point of each warp
    } batches[2];                       // this batch and the next
};

// A block's own cell lists: the neurons sorted by cell.
struct BlockCells {
    std::uint32_t* begin;    // columns + 1 bounds per row of cells
    std::uint32_t* sorting;  // per neuron: cell << 16 | rank in it
    std::uint16_t* ids;
    const SortedNeuron* neurons;  // by neuron
    __device__ std::uint32_t bound(int i) const { return begin[i]; }
    __device__ const SortedNeuron* neuron(std::uint32_t i) const { return &neurons[ids[i]]; }
    // The upper half holds the bound of the neuron's cell if a refresh follows.
    __device__ std::uint32_t id(const SortedNeuron& at) const { return at.id & 0xFFFFu; }
};

// Bytes of shared memory of a block: Scratch and the cell lists.
std::size_t shared_bytes(const LevelView& level) {
    const std::size_t neurons = static_cast<std::size_t>(level.lattice.columns) * level.lattice.rows;
    const std::size_t bounds = static_cast<std::size_t>(level.grid.columns + 1) * level.grid.rows;
    return sizeof(Scratch) + (bounds + neurons) * sizeof(std::uint32_t) + neurons * sizeof(std::uint16_t);
}

// Index of the bound of a position's cell. It is computed once, when the neuron learns, not
// by every block again.
__device__ __forceinline__ std::uint32_t bound_of(const LevelView& level, float x, float y) {
    const int cell = step::cell_of(level.grid, x, y);
    return static_cast<std::uint32_t>(cell + cell / level.grid.columns);
}

// Makes the paper's cell refresh (section 4.2) in every block separately, so that no block
// waits for another's lists.
__device__ void refresh_cells(const LevelView& level, const BlockCells& cells, std::uint32_t batch) {
    using Scan = cub::BlockScan<std::uint32_t, kBlock>;
    __shared__ typename Scan::TempStorage scan_storage;
    const int neurons = level.lattice.columns * level.lattice.rows, pitch = level.grid.columns + 1;
    const int bounds = pitch * level.grid.rows, lane = threadIdx.x % 32;
    for (int c = threadIdx.x; c < bounds; c += kBlock) cells.begin[c] = 0;
    __syncthreads();
    constexpr int kAtOnce = 12;  // loads that a thread has in flight
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

// Reads a record in a single access.
__device__ __forceinline__ uint4 load_record(const uint4* at) {
    uint4 r;
    asm volatile("ld.relaxed.gpu.global.v4.u32 {%0, %1, %2, %3}, [%4];"
                 : "=r"(r.x), "=r"(r.y), "=r"(r.z), "=r"(r.w)
                 : "l"(at));
    return r;
}

// Writes a record in a single access.
__device__ __forceinline__ void store_record(uint4* at, const uint4& r) {
    asm volatile("st.relaxed.gpu.global.v4.u32 [%0], {%1, %2, %3, %4};" ::"l"(at), "r"(r.x), "r"(r.y),
                 "r"(r.z), "r"(r.w)
                 : "memory");
}

// The work of one warp: the learning sums of a patch of neurons over the records of one iteration.
struct SumTask {
    const uint4* records;
    std::uint32_t count, batch;
    int2 patch;  // its column and row, in patches
    int radius;
    const uint2* tables;  // gain and decay for each distance
    uint4* scratch;       // 64 units
};

// Returns the sums of the lane's neuron. The warp waits for the records of the task's batch and lists those
// within reach of the patch; then all lanes add up the listed ones.
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
    constexpr int kAtOnce = 6;  // loads that a lane has in flight
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

// Runs iterations [first, end) in batches, like Trainer in train_large.cu, but no block ever waits for all
// others. Each position and each unit is a record that carries the number of its batch; a reader that finds
// another number reads again. A patch learns only when it has read every record of its batch. Therefore
// - no position is overwritten before all competitions of its batch have read it;
// - no record is overwritten (there are two sets, used in turn) before all patches have read it. For this
//   each block writes at least one record in each batch, and none of the next batch before its patches are
//   done.
template <int kLanes>
class SmallTrainer {
  public:
    __device__ __forceinline__ SmallTrainer(const LevelView& level, const SmallView& view,
                                            const IterationRange& range)
        : level_(level),
          view_(view),
          first_(range.first),
          end_(range.first + range.count),
          crr_(range.crr),
          prr_(range.prr),
          patches_x_((level.lattice.columns + kPatchColumns - 1) / kPatchColumns),
          patches_(patches_x_ * ((level.lattice.rows + kPatchRows - 1) / kPatchRows)) {}

    // batch: number of the first batch.
    __device__ __forceinline__ void run(Scratch& scratch, const BlockCells& cells, int batch) {
        const int neurons = level_.lattice.columns * level_.lattice.rows;
        for (int i = blockIdx.x * kBlock + threadIdx.x; i < neurons; i += gridDim.x * kBlock)
            store_neuron(&level_.sorted[i], level_.x[i], level_.y[i],
                         i | bound_of(level_, level_.x[i], level_.y[i]) << 16, batch);
        prepare(scratch, first_, batch);
        __syncthreads();
        for (int from = first_, to; from < end_; from = to, ++batch) {
            to = step::batch_end(from, end_, crr_, prr_);
            if (from % crr_ == 0) refresh_cells(level_, cells, batch);
            find_units(scratch, cells, from, to - from, batch);
            if (to < end_) prepare(scratch, to, batch + 1);
            learn(scratch, from, to, batch);
        }
    }

  private:
    static constexpr int kGroups = 32 / kLanes;  // groups of a warp

    __device__ __forceinline__ uint4* records_of(int batch) const {
        return view_.records + static_cast<std::size_t>(batch & 1) * prr_ * view_.capacity;
    }
    // Gives the iteration t and the point k of a batch's task; false beyond the last task.
    __device__ __forceinline__ static bool find_task(const Scratch::Batch& batch, int length,
                                                     std::uint32_t task, int& t, std::uint32_t& k) {
        t = 0;
        k = task;
        while (t < length && k >= batch.points[t].y) k -= batch.points[t++].y;
        return t < length;
    }
    // Point k of iteration t of the batch that begins at iteration `from`.
    __device__ __forceinline__ std::uint32_t point_of(int from, int t, std::uint32_t k) const {
        return level_.points[static_cast<std::size_t>(from - first_ + t) * level_.point_capacity + k];
    }

    // Prepares what is known before a batch begins, by the last warps of a block, which are the least likely
    // to have a patch. The last iteration of a batch is padded with empty records until there is one for
    // each block's first group.
    __device__ __forceinline__ void prepare(Scratch& scratch, int from, int number) {
        Scratch::Batch& next = scratch.batches[number & 1];
        const int length = step::batch_end(from, end_, crr_, prr_) - from;
        if (block_warp_ == kWarps - 1) {
            const std::uint32_t own = lane_ < length ? level_.point_count[from + lane_ - first_] : 0;
            std::uint32_t all = own, least = gridDim.x * kGroups;
            for (int step = 16; step > 0; step /= 2) all += __shfl_xor_sync(kAllLanes, all, step);
            if (lane_ < length)
                next.points[lane_] = {own, lane_ == length - 1 && all < least ? own + least - all : own};
            __syncwarp();
            int t;
            std::uint32_t k;
            if (kGroups == 1 && lane_ < kWarps &&
                find_task(next, length, lane_ * gridDim.x + blockIdx.x, t, k) && k < next.points[t].x)
                next.first[lane_] = point_of(from, t, k);
        }
        for (int k = kWarps - 2 - block_warp_; k >= 0 && k < length; k += kWarps - 1) {
            const int t = from + k;
            next.tables[k][lane_] = {level_.gain[t * kTableWidth + lane_],
                                     level_.decay[t * kTableWidth + lane_]};
            if (lane_ == 0) next.radius[k] = level_.radius[t];
        }
    }

    // Finds the best matching units of the batch's points, and writes the records, including empty ones.
    __device__ __forceinline__ void find_units(const Scratch& scratch, const BlockCells& cells, int from,
                                               int length, int batch) {
        const Scratch::Batch& now = scratch.batches[batch & 1];
        uint4* const records = records_of(batch);
        std::uint32_t tasks = 0;
        for (int k = 0; k < length; ++k) tasks += now.points[k].y;
        for (std::uint32_t base = warp_ * kGroups; base < tasks; base += warps_ * kGroups) {
            int t;
            std::uint32_t k;
            const bool task = find_task(now, length, base + lane_ / kLanes, t, k);
            const bool active = task && k < now.points[t].x;
            const std::uint32_t point = !active ? 0
                                        : kGroups == 1 && base == static_cast<std::uint32_t>(warp_)
                                            ? now.first[block_warp_]
                                            : point_of(from, t, k);
            const std::uint32_t neuron =
                GroupSearch<kLanes, BlockCells>(level_, cells, point, batch, active, lane_ % kLanes).run();
            if (!task || lane_ % kLanes != 0) continue;
            std::uint32_t position = kNoUnit;
            if (active && neuron != step::kNoNeuron) {
                const int row = neuron / level_.lattice.columns, column = neuron % level_.lattice.columns;
                position = (static_cast<std::uint32_t>(step::axial_q(column, row)) & 0xFFFFu) |
                           static_cast<std::uint32_t>(row) << 16;
            }
            store_record(&records[t * view_.capacity + k],
                         {position, point & 0xFFFFu, point >> 16, static_cast<std::uint32_t>(batch)});
        }
    }

    // Does the triggering step of the batch: for each patch one warp per iteration finds the targets, and the
    // first of these warps moves the neurons.
    __device__ __forceinline__ void learn(Scratch& scratch, int from, int to, int batch) {
        const Scratch::Batch& now = scratch.batches[batch & 1];
        const uint4* const records = records_of(batch);
        const int columns = level_.lattice.columns, rows = level_.lattice.rows, length = to - from;
        const int groups = kWarps / length, group = block_warp_ / length, k = block_warp_ % length;
        for (int round = 0; round * groups * static_cast<int>(gridDim.x) < patches_; ++round) {
            const int patch = (round * groups + group) * gridDim.x + blockIdx.x;
            const bool working = group < groups && patch < patches_;
            const int2 corner{patch % patches_x_, patch / patches_x_};
            const int column = corner.x * kPatchColumns + lane_ % kPatchColumns,
                      row = corner.y * kPatchRows + lane_ / kPatchColumns, i = row * columns + column;
            const bool inside = working && column < columns && row < rows;
            SortedNeuron at = load_neuron(&level_.sorted[inside ? i : 0]);
            if (working) {
                const step::LearningSums own = sum_of_records(
                    level_,
                    {records + k * view_.capacity, now.points[k].y, static_cast<std::uint32_t>(batch), corner,
                     now.radius[k], now.tables[k], scratch.units[block_warp_]},
                    lane_);
                scratch.targets[round & 1][block_warp_][lane_] = step::target_of(own, at.x, at.y);
            }
            __syncthreads();
            if (!inside || k != 0) continue;
            const step::Border border = border_of(level_);
            const bool rests = step::rests(border, column);
            for (int t = 0; t < length; ++t) {
                const step::Target target = scratch.targets[round & 1][block_warp_ + t][lane_];
                if (target.share == 0.0f || rests) continue;
                step::learn(target, level_.extent_x, level_.extent_y, at.x, at.y);
                if (level_.pinned) step::pin_to_border(border, column, row, at.x, at.y);
            }
            store_neuron(&level_.sorted[i], at.x, at.y,
                         to % crr_ == 0 ? i | bound_of(level_, at.x, at.y) << 16 : i, batch + 1);
            if (to < end_) continue;
            level_.x[i] = at.x;
            level_.y[i] = at.y;
        }
        __syncthreads();
    }

    const LevelView& level_;
    const SmallView& view_;
    const int first_, end_, crr_, prr_;
    const int lane_ = threadIdx.x % 32, block_warp_ = threadIdx.x / 32;
    // Warps are numbered across all blocks first, so that work spreads evenly over the multiprocessors.
    const int warp_ = block_warp_ * gridDim.x + blockIdx.x, warps_ = gridDim.x * kWarps;
    const int patches_x_, patches_;
};

template <int kLanes>
__global__ void __launch_bounds__(kBlock, 1)
    train_small_kernel(LevelView level, SmallView view, IterationRange range, int batch) {
    extern __shared__ uint4 memory[];
    Scratch& scratch = *reinterpret_cast<Scratch*>(memory);
    const int neurons = level.lattice.columns * level.lattice.rows;
    std::uint32_t* const begin = reinterpret_cast<std::uint32_t*>(&scratch + 1);
    std::uint32_t* const sorting = begin + (level.grid.columns + 1) * level.grid.rows;
    const BlockCells cells{begin, sorting, reinterpret_cast<std::uint16_t*>(sorting + neurons), level.sorted};
    SmallTrainer<kLanes>(level, view, range).run(scratch, cells, batch);
}

using Kernel = void (*)(LevelView, SmallView, IterationRange, int);

// Number of blocks for a level.
int blocks_of(const Launch& launch, const LevelView& level) {
    const int patches = (level.lattice.columns + kPatchColumns - 1) / kPatchColumns *
                        ((level.lattice.rows + kPatchRows - 1) / kPatchRows);
    return std::min(launch.multiprocessors, patches);  // each block has a patch, so it waits for all records
}

// Number of records of an iteration: its points, and empty records for up to 4 groups in each block.
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
    // not the number of any batch
    check(cudaMemsetAsync(records, 0xFF, small_records(launch, level, longest) * sizeof *records,
                          launch.stream),
          "clearing the records");
    check(cudaMemsetAsync(level.sorted, 0xFF, neurons * sizeof *level.sorted, launch.stream),
          "clearing the positions");
}

void train_small(const Launch& launch, const LevelView& level, uint4* records, const IterationRange& range) {
    // Batches are numbered from their first iteration on, so that no number occurs twice in a level.
    int blocks = blocks_of(launch, level), batch = range.first;
    const bool warp_each = static_cast<long long>(level.point_capacity) * range.prr <= blocks * kWarps * 4;
    const auto kernel = reinterpret_cast<const void*>(warp_each ? Kernel(train_small_kernel<32>)
                                                                : Kernel(train_small_kernel<8>));
    const std::size_t bytes = shared_bytes(level);
    check(cudaFuncSetAttribute(kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, static_cast<int>(bytes)),
          "allowing shared memory");
    LevelView copy = level;
    SmallView view{records, record_capacity(launch, level)};
    IterationRange iterations = range;
    void* arguments[] = {&copy, &view, &iterations, &batch};
    check(cudaLaunchCooperativeKernel(kernel, dim3(blocks), dim3(kBlock), arguments, bytes, launch.stream),
          "training");
}

}  // namespace hexrelief::cuda
