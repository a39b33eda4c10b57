#include <cub/block/block_scan.cuh>

#include "cuda/check.h"
#include "cuda/som_cluster.h"
#include "cuda/som_steps.cuh"

namespace hexrelief::cuda {
namespace {

constexpr int kBlock = 512, kWarps = kBlock / 32;
constexpr std::size_t kSharedLimit = 220 * 1024;

// A neuron's handle: block that owns its row << 16 | index within the block's rows. Handles order like the neurons.
// A won point as the blocks tell it each other: row << 16 | axial q, and y << 16 | x of the point in half px.
struct Won {
    std::uint32_t place, point;
};
constexpr std::uint32_t kNoPlace = 0x7FFF7FFFu;  // farther from every neuron than any radius

// Shared memory of a block. Own: its rows' positions. Replicated: the cell lists and the points won.
struct Shared {
    float2* home;          // rows_per_block * columns
    std::uint32_t* begin;  // cells + 1
    std::uint32_t* count;  // cells
    std::uint32_t* ids;    // neurons: handles in the order of their cells
    std::uint32_t* sorting;  // neurons: cell << 16 | place within the cell
    Won* won;              // one a point of the iteration, from all blocks
    Won* near;             // those within reach of the block's rows
    Won* patch;            // kWarps * kPatchUnits
    uint2* tables;         // kTableWidth: gain and fall of each distance, 0 beyond the radius
    std::uint32_t* near_count;
};
constexpr int kPatchUnits = 64;

__host__ __device__ inline int rows_per_block(const LevelView& level, int blocks) {
    const int rows = (level.lattice.rows + blocks - 1) / blocks;
    return (rows + kPatchRows - 1) / kPatchRows * kPatchRows;
}

// Lays the arrays out from base on; returns the bytes.
__host__ __device__ inline std::size_t lay_out(const LevelView& level, int blocks, char* base, Shared* shared) {
    std::size_t used = 0;
    const auto take = [&](auto*& pointer, std::size_t count) {
        using T = std::remove_reference_t<decltype(*pointer)>;
        pointer = reinterpret_cast<T*>(base + used);
        used += (count * sizeof(T) + 15) / 16 * 16;
    };
    const std::size_t neurons = static_cast<std::size_t>(level.lattice.columns) * level.lattice.rows;
    const std::size_t cells = static_cast<std::size_t>(level.grid.columns) * level.grid.rows;
    take(shared->home, static_cast<std::size_t>(rows_per_block(level, blocks)) * level.lattice.columns);
    take(shared->begin, cells + 1);
    take(shared->count, cells);
    take(shared->ids, neurons);
    take(shared->sorting, neurons);
    take(shared->won, level.point_capacity);
    take(shared->near, level.point_capacity);
    take(shared->patch, kWarps * kPatchUnits);
    take(shared->tables, kTableWidth);
    take(shared->near_count, 1);
    return used;
}

#if __CUDA_ARCH__ >= 900

__device__ __forceinline__ std::uint32_t shared_address(const void* pointer) {
    return static_cast<std::uint32_t>(__cvta_generic_to_shared(pointer));
}

__device__ __forceinline__ std::uint32_t address_in(std::uint32_t address, std::uint32_t block) {
    std::uint32_t remote;
    asm("mapa.shared::cluster.u32 %0, %1, %2;" : "=r"(remote) : "r"(address), "r"(block));
    return remote;
}

__device__ __forceinline__ float2 load_position(std::uint32_t home_address, std::uint32_t handle) {
    float2 at;
    asm volatile("ld.shared::cluster.v2.f32 {%0, %1}, [%2];"
                 : "=f"(at.x), "=f"(at.y)
                 : "r"(address_in(home_address + (handle & 0xFFFFu) * static_cast<std::uint32_t>(sizeof(float2)), handle >> 16)));
    return at;
}

__device__ __forceinline__ void tell(std::uint32_t won_address, std::uint32_t slot, std::uint32_t block, const Won& won) {
    asm volatile("st.shared::cluster.v2.u32 [%0], {%1, %2};" ::"r"(
                     address_in(won_address + slot * static_cast<std::uint32_t>(sizeof(Won)), block)),
                 "r"(won.place), "r"(won.point)
                 : "memory");
}

__device__ __forceinline__ void wait_for_cluster() {
    asm volatile("barrier.cluster.arrive.release.aligned;\n\tbarrier.cluster.wait.acquire.aligned;" ::: "memory");
}

// The paper's refresh, by every block for itself: all neurons sorted into cells.
__device__ void refresh_cells(const LevelView& level, const Shared& shared, std::uint32_t home_address, int owned) {
    using Scan = cub::BlockScan<std::uint32_t, kBlock>;
    __shared__ typename Scan::TempStorage scan_storage;
    const int neurons = level.lattice.columns * level.lattice.rows, cells = level.grid.columns * level.grid.rows;
    for (int c = threadIdx.x; c < cells; c += kBlock) shared.count[c] = 0;
    __syncthreads();
    for (int i = threadIdx.x; i < neurons; i += kBlock) {
        const std::uint32_t owner = i / owned;
        const float2 at = load_position(home_address, owner << 16 | (i - owner * owned));
        const std::uint32_t cell = step::cell_of(level.grid, at.x, at.y);
        shared.sorting[i] = cell << 16 | atomicAdd(&shared.count[cell], 1u);
    }
    __syncthreads();
    std::uint32_t before = 0;
    for (int first = 0; first < cells; first += kBlock) {
        const int c = first + threadIdx.x;
        const std::uint32_t count = c < cells ? shared.count[c] : 0;
        std::uint32_t start, total;
        Scan(scan_storage).ExclusiveSum(count, start, total);
        if (c < cells) shared.begin[c] = before + start;
        before += total;
        __syncthreads();
    }
    if (threadIdx.x == 0) shared.begin[cells] = before;
    __syncthreads();
    for (int i = threadIdx.x; i < neurons; i += kBlock) {
        const std::uint32_t owner = i / owned, sorting = shared.sorting[i];
        shared.ids[shared.begin[sorting >> 16] + (sorting & 0xFFFFu)] = owner << 16 | (i - owner * owned);
    }
    __syncthreads();
}

__device__ __forceinline__ std::uint64_t measure(const Shared& shared, std::uint32_t home_address, std::uint32_t i, float px,
                                                 float py) {
    const std::uint32_t handle = shared.ids[i];
    const float2 at = load_position(home_address, handle);
    const float dx = at.x - px, dy = at.y - py;
    return candidate_key(dx * dx + dy * dy, handle);
}

// step::spiral_search by a group of lanes; returns the handle of the best matching unit.
template <int kLanes>
__device__ __forceinline__ std::uint32_t search(const LevelView& level, const Shared& shared, std::uint32_t home_address,
                                                std::uint32_t point, bool active, int lane) {
    const step::CellGrid& grid = level.grid;
    const int hx = point & 0xFFFFu, hy = point >> 16;
    const float px = static_cast<float>(hx) * 0.5f, py = static_cast<float>(hy) * 0.5f;
    const int cx = hx / (2 * grid.co), cy = hy / (2 * grid.co), limit = step::ring_limit(grid, level.ssr);
    const int cell = cy * grid.columns + cx;
    std::uint64_t best = candidate_key(step::Candidate{}.squared_distance, step::Candidate{}.neuron);
    const auto consider = [&](std::uint32_t i) {
        const std::uint64_t key = measure(shared, home_address, i, px, py);
        best = key < best ? key : best;
    };
    if (active)
        for (std::uint32_t i = shared.begin[cell] + lane; i < shared.begin[cell + 1]; i += kLanes) consider(i);
    best = least_of_group<kLanes>(best);

    float reach = key_distance(best);
    bool searching = active && !(step::ring_distance(grid, cx, cy, 1, px, py) > reach);
    if (__any_sync(kAllLanes, searching)) {
        Stretch stretch[3] = {};  // the row above, the row below, the own row's left and right as two halves of one
        std::uint32_t west_begin = 0, west_count = 0;
        if (searching) {
            const bool west = cx > 0, east = cx + 1 < grid.columns;
            for (int side = 0; side < 2; ++side) {
                const int v = side ? cy + 1 : cy - 1;
                if (v < 0 || v >= grid.rows || step::cell_distance(grid, cx, v, px, py) > reach) continue;
                const int from = west && !(step::cell_distance(grid, cx - 1, v, px, py) > reach) ? cx - 1 : cx;
                const int to = east && !(step::cell_distance(grid, cx + 1, v, px, py) > reach) ? cx + 1 : cx;
                stretch[side].begin = shared.begin[v * grid.columns + from];
                stretch[side].count = shared.begin[v * grid.columns + to + 1] - stretch[side].begin;
            }
            if (west && !(step::cell_distance(grid, cx - 1, cy, px, py) > reach)) {
                west_begin = shared.begin[cell - 1];
                west_count = shared.begin[cell] - west_begin;
            }
            if (east && !(step::cell_distance(grid, cx + 1, cy, px, py) > reach)) {
                stretch[2].begin = shared.begin[cell + 1];
                stretch[2].count = shared.begin[cell + 2] - stretch[2].begin;
            }
        }
        const std::uint32_t upto0 = stretch[0].count, upto1 = upto0 + stretch[1].count, upto2 = upto1 + west_count;
        const std::uint32_t total = upto2 + stretch[2].count;
        for (std::uint32_t k = lane; k < total; k += kLanes)
            consider(k < upto0   ? stretch[0].begin + k
                     : k < upto1 ? stretch[1].begin + (k - upto0)
                     : k < upto2 ? west_begin + (k - upto1)
                                 : stretch[2].begin + (k - upto2));
        best = least_of_group<kLanes>(best);
    }
    for (int ring = 2;; ++ring) {
        reach = key_distance(best);
        searching = searching && ring <= limit && !(step::ring_distance(grid, cx, cy, ring, px, py) > reach);
        if (!__any_sync(kAllLanes, searching)) break;
        if (searching)
            for (int k = lane; k < 8 * ring; k += kLanes) {
                int u, v;
                step::ring_cell(ring, k, u, v);
                u += cx;
                v += cy;
                if (u < 0 || u >= grid.columns || v < 0 || v >= grid.rows) continue;
                if (step::cell_distance(grid, u, v, px, py) > reach) continue;
                const int other = v * grid.columns + u;
                for (std::uint32_t i = shared.begin[other]; i < shared.begin[other + 1]; ++i) consider(i);
            }
        best = least_of_group<kLanes>(best);
    }
    return static_cast<std::uint32_t>(best);
}

// Keeps of the points won those within `radius` rows of the block's own.
__device__ __forceinline__ void keep_near(const Shared& shared, std::uint32_t drawn, int first_row, int last_row, int radius) {
    const int lane = threadIdx.x % 32;
    for (std::uint32_t base = threadIdx.x - lane; base < drawn; base += kBlock) {
        const std::uint32_t k = base + lane;
        Won won{kNoPlace, 0};
        if (k < drawn) won = shared.won[k];
        const int row = won.place >> 16;
        const bool keep = row >= first_row - radius && row <= last_row + radius;
        const unsigned kept = __ballot_sync(kAllLanes, keep);
        std::uint32_t at = 0;
        if (lane == 0 && kept) at = atomicAdd(shared.near_count, static_cast<std::uint32_t>(__popc(kept)));
        at = __shfl_sync(kAllLanes, at, 0);
        if (keep) shared.near[at + __popc(kept & ((1u << lane) - 1))] = won;
    }
}

// The triggering step of a patch by one warp, from the block's list.
__device__ __forceinline__ void learn_patch(const LevelView& level, const Shared& shared, std::uint32_t near_count, int first_row,
                                            int patch_column, int patch_row, int radius, int lane) {
    const int columns = level.lattice.columns, rows = level.lattice.rows;
    const int column = patch_column * kPatchColumns + lane % kPatchColumns;
    const int local_row = patch_row * kPatchRows + lane / kPatchColumns, row = first_row + local_row;
    const int q = step::axial_q(column, row);
    const int top = first_row + patch_row * kPatchRows - radius, bottom = top + kPatchRows - 1 + 2 * radius;
    const int left = patch_column * kPatchColumns - radius - 1, right = left + kPatchColumns + 2 * radius + 1;
    Won* const list = shared.patch + threadIdx.x / 32 * kPatchUnits;
    step::Pull pull;
    int listed = 0;
    const auto add_all = [&] {
        __syncwarp();
#pragma unroll 4
        for (int k = 0; k < listed; ++k) {
            const Won won = list[k];
            const int dq = static_cast<std::int16_t>(won.place & 0xFFFFu) - q, dr = static_cast<int>(won.place >> 16) - row;
            const int distance = max(max(abs(dq), abs(dr)), abs(dq + dr));
            const uint2 table = shared.tables[min(distance, kTableWidth - 1)];
            pull.gain += table.x;
            pull.x += table.x * (won.point & 0xFFFFu);
            pull.y += table.x * (won.point >> 16);
            pull.fall += table.y;
        }
        __syncwarp();
        listed = 0;
    };
    for (std::uint32_t base = 0; base < near_count; base += 32) {
        Won won{kNoPlace, 0};
        if (base + lane < near_count) won = shared.near[base + lane];
        const int unit_row = won.place >> 16;
        const int unit_column = static_cast<std::int16_t>(won.place & 0xFFFFu) + (unit_row - (unit_row & 1)) / 2;
        const bool keep = unit_row >= top && unit_row <= bottom && unit_column >= left && unit_column <= right;
        const unsigned kept = __ballot_sync(kAllLanes, keep);
        if (listed + __popc(kept) > kPatchUnits) add_all();
        if (keep) list[listed + __popc(kept & ((1u << lane) - 1))] = won;
        listed += __popc(kept);
    }
    add_all();
    if (column >= columns || row >= rows || !pull.gain) return;
    float2& at = shared.home[local_row * columns + column];
    float x = at.x, y = at.y;
    step::learn(pull, level.extent_x, level.extent_y, x, y);
    if (level.pinned) step::pin_to_border(level.lattice, column, row, level.extent_x, level.extent_y, x, y);
    at = {x, y};
}

template <int kLanes>
__device__ __forceinline__ void train_loop(const LevelView& level, int first, int count, int crr) {
    extern __shared__ char memory[];
    const int blocks = gridDim.x, block = blockIdx.x, lane = threadIdx.x % 32, warp = threadIdx.x / 32;
    Shared shared;
    lay_out(level, blocks, memory, &shared);
    const std::uint32_t home_address = shared_address(shared.home), won_address = shared_address(shared.won);
    const int columns = level.lattice.columns, owned_rows = rows_per_block(level, blocks), owned = owned_rows * columns;
    const int first_row = block * owned_rows, last_row = min(first_row + owned_rows, level.lattice.rows) - 1;
    const int patches_x = (columns + kPatchColumns - 1) / kPatchColumns;
    const int patches = last_row >= first_row ? patches_x * ((last_row - first_row + kPatchRows) / kPatchRows) : 0;
    const int base = first_row * columns;
    for (int i = threadIdx.x; i < (last_row - first_row + 1) * columns; i += kBlock)
        shared.home[i] = {level.x[base + i], level.y[base + i]};
    wait_for_cluster();

    constexpr int kGroups = 32 / kLanes;
    const std::uint32_t group = (warp * blocks + block) * kGroups + lane / kLanes, groups = kWarps * blocks * kGroups;
    // what does not depend on positions is asked for an iteration ahead
    const auto point_of = [&](int t) {
        return group < level.point_capacity ? level.points[static_cast<std::size_t>(t - first) * level.point_capacity + group] : 0u;
    };
    std::uint32_t drawn = level.point_count[0], next_point = point_of(first);
    uint2 table = {level.gain[first * kTableWidth + lane], level.fall[first * kTableWidth + lane]};
    int radius = level.radius[first];
    for (int t = first; t < first + count; ++t) {
        if (t % crr == 0) refresh_cells(level, shared, home_address, owned);
        if (threadIdx.x == 0) *shared.near_count = 0;
        if (warp == 0) shared.tables[lane] = table;
        const std::uint32_t* const points = level.points + static_cast<std::size_t>(t - first) * level.point_capacity;
        std::uint32_t point = next_point;
        for (std::uint32_t k = group; __any_sync(kAllLanes, k < drawn); k += groups) {
            const bool active = k < drawn;
            if (k >= groups && active) point = points[k];
            const std::uint32_t handle = search<kLanes>(level, shared, home_address, point, active, lane % kLanes);
            Won won{kNoPlace, point};
            if (handle != 0xFFFFFFFFu) {
                const int local_row = static_cast<int>(handle & 0xFFFFu) / columns;
                const int row = static_cast<int>(handle >> 16) * owned_rows + local_row;
                const int q = step::axial_q(static_cast<int>(handle & 0xFFFFu) - local_row * columns, row);
                won.place = static_cast<std::uint32_t>(row) << 16 | (static_cast<std::uint32_t>(q) & 0xFFFFu);
            }
            if (active)
                for (int b = lane % kLanes; b < blocks; b += kLanes) tell(won_address, k, b, won);
        }
        wait_for_cluster();
        const int now = radius;
        const std::uint32_t won_count = drawn;
        if (t + 1 < first + count) {
            drawn = level.point_count[t + 1 - first];
            next_point = point_of(t + 1);
            table = {level.gain[(t + 1) * kTableWidth + lane], level.fall[(t + 1) * kTableWidth + lane]};
            radius = level.radius[t + 1];
        }
        keep_near(shared, won_count, first_row, last_row, now);
        __syncthreads();
        const std::uint32_t near_count = *shared.near_count;
        for (int patch = warp; patch < patches; patch += kWarps)
            learn_patch(level, shared, near_count, first_row, patch % patches_x, patch / patches_x, now, lane);
        wait_for_cluster();
    }
    for (int i = threadIdx.x; i < (last_row - first_row + 1) * columns; i += kBlock) {
        level.x[base + i] = shared.home[i].x;
        level.y[base + i] = shared.home[i].y;
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

cudaLaunchConfig_t cluster_config(int blocks, std::size_t shared_bytes, cudaLaunchAttribute* attribute, cudaStream_t stream) {
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
    check(cudaDeviceGetAttribute(&major, cudaDevAttrComputeCapabilityMajor, device), "asking for the architecture");
    if (major < 9) return 0;
    for (const TrainKernel kernel : {TrainKernel(cluster_kernel<8>), TrainKernel(cluster_kernel<32>)}) {
        const bool allowed = cudaFuncSetAttribute(kernel, cudaFuncAttributeNonPortableClusterSizeAllowed, 1) == cudaSuccess &&
                             cudaFuncSetAttribute(kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, kSharedLimit) == cudaSuccess;
        if (allowed) continue;
        cudaGetLastError();
        return 0;
    }
    for (int blocks = 16; blocks >= 8; blocks /= 2) {
        cudaLaunchAttribute attribute;
        const cudaLaunchConfig_t config = cluster_config(blocks, kSharedLimit, &attribute, nullptr);
        int clusters = 0;
        if (cudaOccupancyMaxActiveClusters(&clusters, cluster_kernel<8>, &config) == cudaSuccess && clusters > 0) return blocks;
        cudaGetLastError();
    }
    return 0;
}

bool fits_cluster(const Launch& launch, const LevelView& level) {
    if (launch.cluster_blocks == 0) return false;
    const std::size_t neurons = static_cast<std::size_t>(level.lattice.columns) * level.lattice.rows;
    const std::size_t cells = static_cast<std::size_t>(level.grid.columns) * level.grid.rows;
    Shared shared;
    return neurons < 65536 && cells < 65536 && lay_out(level, launch.cluster_blocks, nullptr, &shared) <= kSharedLimit;
}

void train_in_cluster(const Launch& launch, const LevelView& level, int first, int count, int crr) {
    const long long neurons = static_cast<long long>(level.lattice.columns) * level.lattice.rows;
    const bool wide = neurons >= 8LL * level.grid.columns * level.grid.rows;  // neurons of a cell fill a warp, or a quarter of one
    LevelView view = level;
    void* arguments[] = {&view, &first, &count, &crr};
    Shared shared;
    cudaLaunchAttribute attribute;
    const cudaLaunchConfig_t config =
        cluster_config(launch.cluster_blocks, lay_out(level, launch.cluster_blocks, nullptr, &shared), &attribute, launch.stream);
    const auto kernel = wide ? TrainKernel(cluster_kernel<32>) : TrainKernel(cluster_kernel<8>);
    check(cudaLaunchKernelExC(&config, reinterpret_cast<const void*>(kernel), arguments), "training in a cluster");
}

}  // namespace hexrelief::cuda
