#include <cooperative_groups.h>

#include "cuda/check.h"
#include "cuda/som.h"
#include "cuda/som_steps.cuh"

namespace hexrelief::cuda {
namespace {

namespace cg = cooperative_groups;

constexpr int kGridBlock = 1024;

__device__ __forceinline__ void wait_for_grid() {
    cg::this_grid().sync();
}

// The paper's refresh: neurons sorted into cells, rows of cells as one stretch. Stretches stand in any order,
// which nothing that is found in them depends on.
__device__ void refresh_cells(const LevelView& level, const Positions& positions, int thread, int threads) {
    const int neurons = level.lattice.columns * level.lattice.rows, lane = threadIdx.x % 32;
    if (thread == 0) *level.cursor = 0;
    for (int first = thread - lane; first < neurons; first += threads) {
        const int i = first + lane;
        const int cell =
            i < neurons ? step::cell_of(level.grid, __ldcg(&positions.x[i]), __ldcg(&positions.y[i])) : -1;
        const std::uint32_t place = count_in_cell(level.filled, cell);
        if (i < neurons) level.place[i] = place;
    }
    wait_for_grid();
    for (int row = thread / 32; row < level.grid.rows; row += threads / 32) {
        std::uint32_t* const filled = level.filled + row * level.grid.columns;
        std::uint32_t total = 0;
        for (int c = lane; c < level.grid.columns; c += 32) total += __ldcg(&filled[c]);
        for (int step = 16; step > 0; step /= 2) total += __shfl_xor_sync(kAllLanes, total, step);
        std::uint32_t base = lane == 0 ? atomicAdd(level.cursor, total) : 0;
        base = __shfl_sync(kAllLanes, base, 0);
        for (int c0 = 0; c0 < level.grid.columns; c0 += 32) {
            const int c = c0 + lane;
            const std::uint32_t count = c < level.grid.columns ? __ldcg(&filled[c]) : 0;
            std::uint32_t upto = count;
            for (int step = 1; step < 32; step *= 2) {
                const std::uint32_t before = __shfl_up_sync(kAllLanes, upto, step);
                if (lane >= step) upto += before;
            }
            if (c < level.grid.columns) {
                level.begin[row * level.grid.columns + c] = base + upto - count;
                level.end[row * level.grid.columns + c] = base + upto;
                filled[c] = 0;
            }
            base += __shfl_sync(kAllLanes, upto, 31);
        }
    }
    wait_for_grid();
    for (int i = thread; i < neurons; i += threads) {
        const float2 at = {__ldcg(&positions.x[i]), __ldcg(&positions.y[i])};
        const std::uint32_t place =
            __ldcg(&level.begin[step::cell_of(level.grid, at.x, at.y)]) + level.place[i];
        level.place[i] = place;
        level.ids[place] = i;
        positions.sorted[place] = at;
    }
    wait_for_grid();
}

// Search and learning of neighbouring iterations run side by side on different warps: one wait for the grid
// an iteration.
template <int kLanes>
__device__ __forceinline__ void train_loop(const LevelView& level, int first, int count, int crr) {
    const int thread = blockIdx.x * blockDim.x + threadIdx.x, threads = gridDim.x * blockDim.x;
    const int lane = threadIdx.x % 32, end = first + count;
    // warps of all blocks in turn, so that the two kinds of work spread evenly over the multiprocessors
    const int warp = threadIdx.x / 32 * gridDim.x + blockIdx.x, warps = threads / 32;
    const int patches_x = (level.lattice.columns + kPatchColumns - 1) / kPatchColumns;
    const int patches = patches_x * ((level.lattice.rows + kPatchRows - 1) / kPatchRows);
    constexpr int kGroups = 32 / kLanes;  // of a warp
    extern __shared__ uint4 shared[];
    PatchScratch& scratch = reinterpret_cast<PatchScratch*>(shared)[threadIdx.x / 32];
    const Positions positions[2] = {{level.x, level.y, level.sorted[0]},
                                    {level.old_x, level.old_y, level.sorted[1]}};

    const auto search_all = [&](int t, const float2* sorted, int first_warp) {
        const std::uint32_t drawn = level.point_count[t - first];
        const std::uint32_t* const points =
            level.points + static_cast<std::size_t>(t - first) * level.point_capacity;
        for (std::uint32_t base = ((warp - first_warp + warps) % warps) * kGroups; base < drawn;
             base += warps * kGroups) {
            const std::uint32_t k = base + lane / kLanes;
            const bool active = k < drawn;
            const std::uint32_t point = active ? points[k] : 0;
            const std::uint32_t neuron = search_by_group<kLanes>(level, sorted, point, active, lane % kLanes);
            if (active && lane % kLanes == 0 && neuron != 0xFFFFFFFFu)
                add_unit(level, level.units[t % 3], neuron, point);
        }
    };
    refresh_cells(level, positions[1], thread, threads);
    for (int i = thread; i < level.lattice.columns * level.lattice.rows; i += threads)
        level.sorted[0][level.place[i]] = {__ldcg(&level.x[i]), __ldcg(&level.y[i])};
    search_all(first, positions[1].sorted, 0);
    wait_for_grid();
    for (int t = first; t < end; ++t) {
        const Positions& from = positions[(t - first) & 1];
        const Positions& to = positions[(t - first + 1) & 1];
        if (t + 1 < end && (t + 1) % crr == 0) refresh_cells(level, from, thread, threads);
        scratch.tables[lane] = {level.gain[t * kTableWidth + lane], level.fall[t * kTableWidth + lane]};
        const int radius = level.radius[t];
        __syncwarp();
        for (int patch = warp; patch < patches; patch += warps)
            learn_patch(level, level.units[t % 3], level.units[(t + 2) % 3], from, to, patch % patches_x,
                        patch / patches_x, radius, scratch, lane);
        if (t + 1 < end) search_all(t + 1, from.sorted, patches % warps);
        wait_for_grid();
    }
    if ((count & 1) == 0) return;  // the newest positions are where they belong
    for (int i = thread; i < level.lattice.columns * level.lattice.rows; i += threads) {
        const float x = __ldcg(&level.x[i]), y = __ldcg(&level.y[i]);
        level.x[i] = __ldcg(&level.old_x[i]);
        level.y[i] = __ldcg(&level.old_y[i]);
        level.old_x[i] = x;
        level.old_y[i] = y;
    }
}

template <int kLanes>
__global__ void __launch_bounds__(kGridBlock, 1) grid_kernel(LevelView level, int first, int count, int crr) {
    train_loop<kLanes>(level, first, count, crr);
}

using TrainKernel = void (*)(LevelView, int, int, int);

}  // namespace

void train(const Launch& launch, const LevelView& level, int first, int count, int crr) {
    const long long neurons = static_cast<long long>(level.lattice.columns) * level.lattice.rows;
    const bool wide = neurons >= 8LL * level.grid.columns *
                                     level.grid.rows;  // neurons of a cell fill a warp, or a quarter of one
    const auto kernel =
        reinterpret_cast<const void*>(wide ? TrainKernel(grid_kernel<16>) : TrainKernel(grid_kernel<8>));
    constexpr int kSharedBytes = kGridBlock / 32 * sizeof(PatchScratch);
    check(cudaFuncSetAttribute(kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, kSharedBytes),
          "allowing shared memory");
    LevelView view = level;
    void* arguments[] = {&view, &first, &count, &crr};
    check(cudaLaunchCooperativeKernel(kernel, dim3(launch.multiprocessors), dim3(kGridBlock), arguments,
                                      kSharedBytes, launch.stream),
          "training");
}

}  // namespace hexrelief::cuda
