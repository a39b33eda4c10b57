#include "cuda/common/check.h"
#include "cuda/som/learn.cuh"
#include "cuda/som/level.h"

namespace hexrelief::cuda {
namespace {

constexpr int kBlock = 896, kWarps = kBlock / 32;  // the fastest of 640 to 1024
constexpr int kMostTasks = 384;                    // patches x iterations between two waits of a block
// least number of rounds of a block's tasks; with fewer, less iterations are combined in a task
constexpr int kLeastRounds = 2;
constexpr int kCorners = 256;  // number of patches whose corners a block stores
static_assert(kWarps >= som::kMostBatch);

struct Scratch {  // A block's shared memory.
    uint4 units[kWarps][32 * kUnitsAtOnce];
    step::Target targets[kMostTasks][32];
    uint2 tables[som::kMostBatch][kTableWidth];  // gain and decay for each distance, 0 beyond the radius
    // number of points drawn in each iteration of this batch and the next
    std::uint32_t points[2][som::kMostBatch];
    int radius[som::kMostBatch];
    int2 corners[kCorners];
};

// Waits for all blocks. It is a third faster than cooperative_groups, because a block does not wait until its
// own arrival is written.
__device__ __forceinline__ void wait_for_grid(std::uint32_t* arrived, std::uint32_t& expected) {
    __syncthreads();
    expected += gridDim.x;
    if (threadIdx.x == 0) {
        asm volatile("red.release.gpu.global.add.u32 [%0], 1;" ::"l"(arrived) : "memory");
        std::uint32_t seen;
        do asm volatile("ld.acquire.gpu.global.u32 %0, [%1];" : "=r"(seen) : "l"(arrived) : "memory");
        while (static_cast<std::int32_t>(seen - expected) < 0);
    }
    __syncthreads();
}

// Returns one of the level's sets of units.
__device__ __forceinline__ UnitSums units_of(const LevelView& level, int set) {
    const std::size_t neurons = static_cast<std::size_t>(level.lattice.columns) * level.lattice.rows;
    return {level.units.sums + set * neurons,
            level.units.mask + static_cast<std::size_t>(set) * level.words * level.lattice.rows};
}

// The paper's cell refresh (section 4.2) as a counting sort in three parts with waits between them: neurons
// are counted by cell (at the start in a pass of their own, later when they learn), each row of cells gets
// one range of the sorted neurons, and neurons are scattered into these ranges. The order of the ranges is
// arbitrary; no result depends on it.
//
// Counts one neuron in its cell; all lanes of a warp must call.
__device__ __forceinline__ void count_neuron(const LevelView& level, int i, bool valid, float x, float y) {
    const std::uint32_t rank = count_in_cell(level.filled, valid ? step::cell_of(level.grid, x, y) : -1);
    if (valid) level.sorted_index[i] = rank;
}

// Gives each row of cells its range, and each cell its part of it.
__device__ __forceinline__ void assign_cell_ranges(const LevelView& level, int warp, int warps, int lane) {
    const int columns = level.grid.columns;
    for (int row = warp; row < level.grid.rows; row += warps) {
        std::uint32_t* const filled = level.filled + row * columns;
        std::uint32_t* const begin = level.begin + row * (columns + 1);
        std::uint32_t total = 0;
        for (int c = lane; c < columns; c += 32) total += __ldcg(&filled[c]);
        for (int step = 16; step > 0; step /= 2) total += __shfl_xor_sync(kAllLanes, total, step);
        std::uint32_t base = lane == 0 ? atomicAdd(level.cursor, total) : 0;
        base = __shfl_sync(kAllLanes, base, 0);
        if (lane == 0) begin[columns] = base + total;
        for (int c0 = 0; c0 < columns; c0 += 32) {
            const int c = c0 + lane;
            const std::uint32_t count = c < columns ? __ldcg(&filled[c]) : 0;
            std::uint32_t upto = count;
            for (int step = 1; step < 32; step *= 2) {
                const std::uint32_t before = __shfl_up_sync(kAllLanes, upto, step);
                if (lane >= step) upto += before;
            }
            if (c < columns) {
                begin[c] = base + upto - count;
                filled[c] = 0;
            }
            base += __shfl_sync(kAllLanes, upto, 31);
        }
    }
}

// Writes the neurons to their places in the ranges.
__device__ __forceinline__ void scatter_neurons(const LevelView& level, std::uint32_t batch, int thread,
                                                int threads) {
    const int neurons = level.lattice.columns * level.lattice.rows;
    if (thread == 0) *level.cursor = 0;
    for (int i = thread; i < neurons; i += threads) {
        const float2 at = {__ldcg(&level.x[i]), __ldcg(&level.y[i])};
        const int cell = step::cell_of(level.grid, at.x, at.y), row = cell / level.grid.columns;
        const std::uint32_t index = __ldcg(&level.begin[cell + row]) + __ldcg(&level.sorted_index[i]);
        level.sorted_index[i] = index;
        store_neuron(&level.sorted[index], at.x, at.y, i, batch);
    }
}

// Runs iterations [first, end) of the level, whose points were drawn as iterations [0, end - first) of
// level.points. The competitions of all iterations of a batch see the positions at its start. Then each patch
// of neurons learns: one warp per iteration, or per few of them, finds the targets, which need no later
// positions, and one warp moves the neurons to one target after the other. All threads of the grid call it.
template <int kLanes>
class Trainer {
  public:
    __device__ __forceinline__ Trainer(const LevelView& level, int first, int end, int crr, int prr,
                                       Scratch& scratch)
        : level_(level),
          first_(first),
          end_(end),
          crr_(crr),
          prr_(prr),
          scratch_(scratch),
          patches_x_((level.lattice.columns + kPatchColumns - 1) / kPatchColumns) {
        const int patches = patches_x_ * ((level.lattice.rows + kPatchRows - 1) / kPatchRows);
        own_ = (patches - static_cast<int>(blockIdx.x) + static_cast<int>(gridDim.x) - 1) /
               static_cast<int>(gridDim.x);
        for (int k = threadIdx.x; k < min(own_, kCorners); k += kBlock) scratch.corners[k] = corner_at(k);
    }

    // batch: number of the first batch.
    __device__ __forceinline__ void run(int batch) {
        count_points(first_, batch);
        count_all_neurons();
        wait_for_grid(level_.arrived, expected_);
        for (int from = first_, to; from < end_; from = to, ++batch) {
            to = step::batch_end(from, end_, crr_, prr_);
            const int length = to - from;
            if (from % crr_ == 0) {
                assign_cell_ranges(level_, warp_, warps_, lane_);
                wait_for_grid(level_.arrived, expected_);
                scatter_neurons(level_, batch, thread_, threads_);
            }
            load_tables(from, length);
            if (from % crr_ == 0) wait_for_grid(level_.arrived, expected_);
            find_units(from, length, batch);
            // Clears the next batch's set while other blocks still search: nobody reads it any more, and
            // nobody adds to it yet.
            for (int k = block_warp_; k < own_; k += kWarps) {
                const int2 corner = corner_of(k);
                clear_patch(level_, (batch + 1) % 3 * prr_, prr_, corner.x, corner.y, lane_);
            }
            wait_for_grid(level_.arrived, expected_);
            count_points(to, batch + 1);
            const bool refresh_next = to % crr_ == 0 && to < end_;
            learn(length, batch, refresh_next);
            if (refresh_next)
                wait_for_grid(level_.arrived, expected_);
            else
                __syncthreads();  // the next batch's points are counted
        }
    }

  private:
    static constexpr int kGroups = 32 / kLanes;  // groups of a warp

    // Column and row, in patches, of the block's k-th patch.
    __device__ __forceinline__ int2 corner_at(int k) const {
        const int patch = k * gridDim.x + blockIdx.x;
        return int2{patch % patches_x_, patch / patches_x_};
    }
    // Returns the stored corner, because divisions would cost as much as the rest of a task's overhead.
    __device__ __forceinline__ int2 corner_of(int k) const {
        return k < kCorners ? scratch_.corners[k] : corner_at(k);
    }

    // Reads the numbers of points of the batch that begins at iteration `from`.
    __device__ __forceinline__ void count_points(int from, int batch) {
        const int k = threadIdx.x;
        if (k < prr_ && from + k < end_)
            scratch_.points[batch & 1][k] = level_.point_count[from + k - first_];
    }

    __device__ __forceinline__ void count_all_neurons() {
        const int neurons = level_.lattice.columns * level_.lattice.rows;
        for (int i0 = thread_ - lane_; i0 < neurons; i0 += threads_) {
            const int i = i0 + lane_;
            const bool valid = i < neurons;
            count_neuron(level_, i, valid, valid ? level_.x[i] : 0.0f, valid ? level_.y[i] : 0.0f);
        }
    }

    // Loads the learning tables of the batch.
    __device__ __forceinline__ void load_tables(int from, int length) {
        for (int k = block_warp_; k < length; k += kWarps) {
            const int t = from + k;
            scratch_.tables[k][lane_] = {level_.gain[t * kTableWidth + lane_],
                                         level_.decay[t * kTableWidth + lane_]};
            if (lane_ == 0) scratch_.radius[k] = level_.radius[t];
        }
    }

    // Finds the best matching units of all points of the batch.
    __device__ __forceinline__ void find_units(int from, int length, int batch) {
        const GlobalCells cells{level_.begin, level_.sorted};
        const std::uint32_t* const points = scratch_.points[batch & 1];
        std::uint32_t drawn = 0;
        for (int k = 0; k < length; ++k) drawn += points[k];
        for (std::uint32_t base = warp_ * kGroups; base < drawn; base += warps_ * kGroups) {
            std::uint32_t k = base + lane_ / kLanes;
            const bool active = k < drawn;
            int t = 0;
            while (active && k >= points[t]) k -= points[t++];
            const std::size_t iteration = static_cast<std::size_t>(from - first_ + t);
            const std::uint32_t point = active ? level_.points[iteration * level_.point_capacity + k] : 0;
            const std::uint32_t neuron =
                GroupSearch<kLanes, GlobalCells>(level_, cells, point, batch, active, lane_ % kLanes).run();
            if (active && lane_ % kLanes == 0 && neuron != step::kNoNeuron)
                add_unit(level_, units_of(level_, batch % 3 * prr_ + t), neuron, point);
        }
    }

    // Does the triggering step of the batch, for as many of the block's patches at a time
    // as their targets fit.
    __device__ __forceinline__ void learn(int length, int batch, bool refresh_next) {
        // the radius never grows, so that of the first iteration is the largest
        LaneSplit split = split_lanes(scratch_.radius[0]);
        const auto parts_of_patch = [&] { return (length + split.iterations() - 1) / split.iterations(); };
        while (split.shift < 5 && own_ * parts_of_patch() < kLeastRounds * kWarps) ++split.shift;
        const int parts = parts_of_patch();
        // for dividing a task's number, which is small like the divisor
        const int over_parts = 65536 / parts + 1;
        const int most = kMostTasks / length;  // patches at a time
        for (int begin = 0; begin < own_; begin += most) {
            const int some = min(most, own_ - begin);
            for (int task = block_warp_; task < some * parts; task += kWarps) {
                const int p = task * over_parts >> 16, k = (task - p * parts) * split.iterations();
                find_targets_of(corner_of(begin + p), length, batch, split, k,
                                &scratch_.targets[p * length + k]);
            }
            __syncthreads();
            for (int task = block_warp_; task < some; task += kWarps)
                move_neurons(corner_of(begin + task), &scratch_.targets[task * length], length, batch,
                             refresh_next);
            if (begin + most < own_) __syncthreads();
        }
    }

    // Finds the targets of a patch in iterations k and following of the batch, by one warp.
    __device__ __forceinline__ void find_targets_of(int2 corner, int length, int batch, LaneSplit split,
                                                    int k, step::Target (*targets)[32]) {
        const int column = corner.x * kPatchColumns + lane_ % kPatchColumns,
                  row = corner.y * kPatchRows + lane_ / kPatchColumns,
                  i = row * level_.lattice.columns + column;
        float x = 0, y = 0;
        // Positions are loaded early, though needed last.
        if (column < level_.lattice.columns && row < level_.lattice.rows) {
            x = __ldcg(&level_.x[i]);
            y = __ldcg(&level_.y[i]);
        }
        find_targets(level_,
                     {batch % 3 * prr_ + k, min(length - k, split.iterations()), split, corner,
                      &scratch_.radius[k], &scratch_.tables[k], scratch_.units[block_warp_], targets},
                     lane_, x, y);
    }

    // Moves the neurons of a patch to the targets of all iterations of the batch, by one warp.
    __device__ __forceinline__ void move_neurons(int2 corner, const step::Target (*targets)[32], int length,
                                                 int batch, bool refresh_next) {
        const int column = corner.x * kPatchColumns + lane_ % kPatchColumns,
                  row = corner.y * kPatchRows + lane_ / kPatchColumns,
                  i = row * level_.lattice.columns + column;
        const bool inside = column < level_.lattice.columns && row < level_.lattice.rows;
        float x = 0, y = 0;
        std::uint32_t sorted_index = 0;
        if (inside) {
            x = __ldcg(&level_.x[i]);
            y = __ldcg(&level_.y[i]);
            sorted_index = __ldcg(&level_.sorted_index[i]);
        }
        const step::Border border = border_of(level_);
        const bool rests = step::rests(border, column);
        for (int t = 0; t < length; ++t) {
            const step::Target target = targets[t][lane_];
            if (target.share == 0.0f || rests) continue;
            step::learn(target, level_.extent_x, level_.extent_y, x, y);
            if (level_.pinned) step::pin_to_border(border, column, row, x, y);
        }
        if (inside) {
            level_.x[i] = x;
            level_.y[i] = y;
            store_neuron(&level_.sorted[sorted_index], x, y, i, batch + 1);
        }
        __syncwarp();
        if (refresh_next) count_neuron(level_, i, inside, x, y);
    }

    const LevelView& level_;
    const int first_, end_, crr_, prr_;
    Scratch& scratch_;
    const int lane_ = threadIdx.x % 32, block_warp_ = threadIdx.x / 32;
    const int thread_ = blockIdx.x * kBlock + threadIdx.x, threads_ = gridDim.x * kBlock;
    // Warps are numbered across all blocks first, so that work spreads evenly over the multiprocessors.
    const int warp_ = block_warp_ * gridDim.x + blockIdx.x, warps_ = threads_ / 32;
    const int patches_x_;
    int own_;  // number of this block's patches
    std::uint32_t expected_ = 0;
};

template <int kLanes>
__global__ void __launch_bounds__(kBlock, 1)
    train_kernel(LevelView level, int first, int end, int crr, int prr, int batch) {
    extern __shared__ uint4 memory[];
    Trainer<kLanes>(level, first, end, crr, prr, *reinterpret_cast<Scratch*>(memory)).run(batch);
}

using TrainKernel = void (*)(LevelView, int, int, int, int, int);

// Returns the kernel with the right number of lanes per search: a whole warp if all points of a batch
// can then be searched at once; otherwise about as many lanes as a cell has neurons, unless most points
// would have to wait.
TrainKernel kernel_for(const LevelView& level, int prr, long long warps) {
    const long long neurons = static_cast<long long>(level.lattice.columns) * level.lattice.rows;
    // upper bound
    const long long points = static_cast<long long>(level.point_capacity) * prr;
    if (points <= warps) return train_kernel<32>;
    const bool wide = neurons >= 8LL * level.grid.columns * level.grid.rows;
    return wide && points <= 8 * warps ? train_kernel<16> : train_kernel<8>;
}

}  // namespace

void train(const Launch& launch, const LevelView& level, const IterationRange& range) {
    int first = range.first, end = first + range.count, crr = range.crr, prr = range.prr;
    int blocks = launch.multiprocessors, batch = 0;
    const auto kernel = reinterpret_cast<const void*>(kernel_for(level, prr, blocks * kWarps));
    check(cudaFuncSetAttribute(kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, sizeof(Scratch)),
          "allowing shared memory");
    check(cudaMemsetAsync(level.arrived, 0, 2 * sizeof(std::uint32_t), launch.stream), "clearing");
    const std::size_t sets = 3 * static_cast<std::size_t>(prr),
                      neurons = static_cast<std::size_t>(level.lattice.columns) * level.lattice.rows,
                      words = static_cast<std::size_t>(level.words) * level.lattice.rows;
    check(cudaMemsetAsync(level.units.sums, 0, sets * neurons * sizeof *level.units.sums, launch.stream),
          "clearing the units");
    check(cudaMemsetAsync(level.units.mask, 0, sets * words * sizeof *level.units.mask, launch.stream),
          "clearing the units");
    LevelView view = level;
    void* arguments[] = {&view, &first, &end, &crr, &prr, &batch};
    check(cudaLaunchCooperativeKernel(kernel, dim3(blocks), dim3(kBlock), arguments, sizeof(Scratch),
                                      launch.stream),
          "training");
}

}  // namespace hexrelief::cuda
