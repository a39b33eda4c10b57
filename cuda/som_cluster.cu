#include "cuda/check.h"
#include "cuda/som_cluster.h"
#include "cuda/som_cluster_steps.cuh"

namespace hexrelief::cuda {
namespace {

constexpr std::size_t kSharedLimit = 220 * 1024;

#if __CUDA_ARCH__ >= 900

// Search and learning of neighbouring iterations run side by side on different warps: one wait for the
// cluster an iteration.
template <int kLanes>
__device__ __forceinline__ void train_loop(const LevelView& level, int first, int count, int crr) {
    extern __shared__ char memory[];
    const int blocks = gridDim.x, block = blockIdx.x, lane = threadIdx.x % 32, warp = threadIdx.x / 32,
              end = first + count;
    Shared shared;
    lay_out(level, blocks, memory, &shared);
    // selected, not indexed: an array indexed at run time would live in local memory
    const auto home = [&](int k) { return k ? shared.home[1] : shared.home[0]; };
    const auto won_of = [&](int k) { return k ? shared.won[1] : shared.won[0]; };
    const auto tables_of = [&](int k) { return k ? shared.tables[1] : shared.tables[0]; };
    const std::uint32_t count_address = shared_address(shared.won_count);
    const int columns = level.lattice.columns, per_block = rows_per_block(level, blocks),
              owned = per_block * columns;
    const std::uint32_t column_factor = 0xFFFFFFFFu / columns + 1,
                        block_factor = 0xFFFFFFFFu / per_block + 1;  // divisor()
    const Rows rows{block * per_block, min((block + 1) * per_block, level.lattice.rows) - 1, per_block};
    const int tiles_x = (columns + kTileColumns - 1) / kTileColumns;
    const int tiles =
        rows.last >= rows.first ? tiles_x * ((rows.last - rows.first + kTileRows) / kTileRows) : 0;
    const int base = rows.first * columns, held = (rows.last - rows.first + 1) * columns;
    for (int i = threadIdx.x; i < owned; i += kBlock) {
        shared.home[0][i] = i < held ? float2{level.x[base + i], level.y[base + i]} : float2{};
        shared.home[1][i] = i < held ? float2{level.old_x[base + i], level.old_y[base + i]} : float2{};
    }
    if (threadIdx.x < 3) shared.won_count[threadIdx.x] = 0;
    if (warp == 0)
        tables_of(first & 1)[lane] = {level.gain[first * kTableWidth + lane],
                                      level.fall[first * kTableWidth + lane]};

    // what does not depend on positions is asked for an iteration ahead
    constexpr int kGroups = 32 / kLanes;
    const bool searcher = warp >= kLearnWarps;
    const std::uint32_t groups = kSearchWarps * blocks * kGroups;
    const std::uint32_t group =
        searcher ? ((warp - kLearnWarps) * blocks + block) * kGroups + lane / kLanes : groups;
    struct Ahead {
        std::uint32_t drawn, point;
        int radius;
        uint2 table;
    };
    const auto ask = [&](int t) {
        Ahead ahead{};
        if (t >= end) return ahead;
        ahead.drawn = level.point_count[t - first];
        if (group < ahead.drawn)
            ahead.point = level.points[static_cast<std::size_t>(t - first) * level.point_capacity + group];
        ahead.radius = level.radius[t];
        if (warp == 0) ahead.table = {level.gain[t * kTableWidth + lane], level.fall[t * kTableWidth + lane]};
        return ahead;
    };
    const auto search_all = [&](int t, std::uint32_t home_address, const Ahead& ahead) {
        const std::uint32_t* const points =
            level.points + static_cast<std::size_t>(t - first) * level.point_capacity;
        std::uint32_t point = ahead.point;
        for (std::uint32_t k = group; __any_sync(kAllLanes, k < ahead.drawn); k += groups) {
            const bool active = k < ahead.drawn;
            if (!active)
                point = 0;  // what was asked for ahead is nothing there
            else if (k >= groups)
                point = points[k];
            const std::uint32_t handle =
                search<kLanes>(level, shared, home_address, point, active, lane % kLanes);
            if (!active || handle == 0xFFFFFFFFu) continue;
            const int local_row = __umulhi(handle & 0xFFFFu, column_factor),
                      row = static_cast<int>(handle >> 16) * per_block + local_row;
            const int q = step::axial_q(static_cast<int>(handle & 0xFFFFu) - local_row * columns, row);
            const Won won{static_cast<std::uint32_t>(row) << 16 | (static_cast<std::uint32_t>(q) & 0xFFFFu),
                          point};
            const int last = __umulhi(min(row + ahead.radius, level.lattice.rows - 1), block_factor);
            for (int b = __umulhi(max(row - ahead.radius, 0), block_factor) + lane % kLanes; b <= last;
                 b += kLanes)
                tell(shared_address(won_of(t & 1)), count_address + t % 3 * 4, b, won);
        }
    };
    Ahead now = ask(first), soon = ask(first + 1);
    wait_for_cluster();
    refresh_cells(level, shared, shared_address(home(1)), owned);
    if (searcher) search_all(first, shared_address(home(1)), now);
    wait_for_cluster();
    for (int t = first; t < end; ++t) {
        const int current = (t - first) & 1;
        const bool more = t + 1 < end;
        if (more && (t + 1) % crr == 0) refresh_cells(level, shared, shared_address(home(current)), owned);
        if (searcher) {
            if (more) search_all(t + 1, shared_address(home(current)), soon);
        } else {
            const std::uint32_t won_count = shared.won_count[t % 3];
            int tile_column = warp % tiles_x, tile_row = warp / tiles_x;
            for (int tile = warp; tile < tiles; tile += kLearnWarps) {
                learn_tile(level, rows, won_of(t & 1), won_count, tables_of(t & 1), now.radius,
                           shared.tile + warp * kTileUnits, tile_column, tile_row, home(current),
                           home(current ^ 1), lane);
                for (tile_column += kLearnWarps; tile_column >= tiles_x; tile_column -= tiles_x) ++tile_row;
            }
            if (warp == 0) tables_of((t + 1) & 1)[lane] = soon.table;
            if (threadIdx.x == 0) shared.won_count[(t + 2) % 3] = 0;
        }
        now = soon;
        soon = ask(t + 2);
        wait_for_cluster();
    }
    const int current = count & 1;
    for (int i = threadIdx.x; i < held; i += kBlock) {
        level.x[base + i] = home(current)[i].x;
        level.y[base + i] = home(current)[i].y;
        level.old_x[base + i] = home(current ^ 1)[i].x;
        level.old_y[base + i] = home(current ^ 1)[i].y;
    }
}

#endif

template <int kLanes>
__global__ void __launch_bounds__(kBlock) cluster_kernel(LevelView level, int first, int count, int crr) {
#if __CUDA_ARCH__ >= 900
    train_loop<kLanes>(level, first, count, crr);
#endif
}

using TrainKernel = void (*)(LevelView, int, int, int);

cudaLaunchConfig_t cluster_config(int blocks, std::size_t shared_bytes, cudaLaunchAttribute* attribute,
                                  cudaStream_t stream) {
    attribute->id = cudaLaunchAttributeClusterDimension;
    attribute->val.clusterDim = {static_cast<unsigned>(blocks), 1, 1};
    cudaLaunchConfig_t config = {};
    config.gridDim = dim3(blocks);
    config.blockDim = dim3(kBlock);
    config.dynamicSmemBytes = shared_bytes;
    config.stream = stream;
    config.attrs = attribute;
    config.numAttrs = 1;
    return config;
}

}  // namespace

int training_cluster_blocks() {
    int device = 0, major = 0;
    check(cudaGetDevice(&device), "asking for the device");
    check(cudaDeviceGetAttribute(&major, cudaDevAttrComputeCapabilityMajor, device),
          "asking for the architecture");
    if (major < 9) return 0;
    for (const TrainKernel kernel : {TrainKernel(cluster_kernel<8>), TrainKernel(cluster_kernel<32>)}) {
        const bool allowed =
            cudaFuncSetAttribute(kernel, cudaFuncAttributeNonPortableClusterSizeAllowed, 1) == cudaSuccess &&
            cudaFuncSetAttribute(kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, kSharedLimit) ==
                cudaSuccess;
        if (allowed) continue;
        cudaGetLastError();
        return 0;
    }
    for (int blocks = 16; blocks >= 8; blocks /= 2) {
        cudaLaunchAttribute attribute;
        const cudaLaunchConfig_t config = cluster_config(blocks, kSharedLimit, &attribute, nullptr);
        int clusters = 0;
        if (cudaOccupancyMaxActiveClusters(&clusters, cluster_kernel<8>, &config) == cudaSuccess &&
            clusters > 0)
            return blocks;
        cudaGetLastError();
    }
    return 0;
}

bool fits_cluster(const Launch& launch, const LevelView& level) {
    if (launch.cluster_blocks == 0) return false;
    const std::size_t neurons = static_cast<std::size_t>(level.lattice.columns) * level.lattice.rows;
    const std::size_t cells = static_cast<std::size_t>(level.grid.columns) * level.grid.rows;
    Shared shared;
    return neurons < 65536 && cells < 65536 &&
           lay_out(level, launch.cluster_blocks, nullptr, &shared) <= kSharedLimit;
}

void train_in_cluster(const Launch& launch, const LevelView& level, int first, int count, int crr) {
    const long long neurons = static_cast<long long>(level.lattice.columns) * level.lattice.rows;
    const bool wide = neurons >= 8LL * level.grid.columns *
                                     level.grid.rows;  // neurons of a cell fill a warp, or a quarter of one
    LevelView view = level;
    void* arguments[] = {&view, &first, &count, &crr};
    Shared shared;
    cudaLaunchAttribute attribute;
    const cudaLaunchConfig_t config =
        cluster_config(launch.cluster_blocks, lay_out(level, launch.cluster_blocks, nullptr, &shared),
                       &attribute, launch.stream);
    const auto kernel = wide ? TrainKernel(cluster_kernel<32>) : TrainKernel(cluster_kernel<8>);
    check(cudaLaunchKernelExC(&config, reinterpret_cast<const void*>(kernel), arguments),
          "training in a cluster");
}

}  // namespace hexrelief::cuda
