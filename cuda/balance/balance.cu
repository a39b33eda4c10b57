#include "cuda/balance/balance.h"
#include "cuda/balance/iteration.cuh"
#include "cuda/common/check.h"

#include <type_traits>

namespace hexrelief::cuda {
namespace {

constexpr int kBlock = 512;  // leaves 128 registers per thread
constexpr std::size_t kSharedLimit = 208 * 1024;
constexpr int kMostBlockVertices = 700;  // larger lattices are faster in a cluster
static_assert(kBlock / 32 * 16 <= SharedScratch::kPartials);
constexpr int kMostClusterVertices = 20000;  // larger lattices are faster in a grid

// Lays out a window of the view's arrays in `base`: rows [first - 1, first + count + 1), and one row more on
// either side for multipliers. The pointers are shifted so that indices into the whole lattice are valid.
// Returns the number of bytes; a null base only counts them.
__host__ __device__ inline std::size_t lay_out(int first, int count, char* base, step::BalanceView& v,
                                               std::uint8_t*& marks, std::uint8_t*& grown) {
    std::size_t used = 0;
    const int columns = v.lattice.columns;
    const auto take = [&](auto*& pointer, int row_length) {
        using T = std::remove_reference_t<decltype(*pointer)>;
        if (base)
            pointer = reinterpret_cast<T*>(base + used) - static_cast<std::ptrdiff_t>(first - 1) * row_length;
        used += (static_cast<std::size_t>(count + 2) * row_length * sizeof(T) + 15) / 16 * 16;
    };
    take(v.edges, 3 * v.slots);
    take(v.right_flux, 1);
    for (float** array : {&v.x, &v.y, &v.inverse_xx, &v.inverse_xy, &v.inverse_yy, &v.reach, &v.step_x,
                          &v.step_y, &v.scale, &v.next_scale})
        take(*array, columns);
    take(v.gradient_x, 3 * columns);
    take(v.gradient_y, 3 * columns);
    for (float** array : {&v.multiplier, &v.next_multiplier}) {
        if (base)  // padded row r is lattice row r - 2
            *array = reinterpret_cast<float*>(base + used) - static_cast<std::ptrdiff_t>(first) * v.stride;
        used += (static_cast<std::size_t>(count + 4) * v.stride * sizeof(float) + 15) / 16 * 16;
    }
    take(marks, columns);
    take(grown, columns);
    return used;
}

std::size_t shared_bytes(const step::BalanceView& view, int rows) {
    step::BalanceView v = view;
    std::uint8_t *marks = nullptr, *grown = nullptr;
    return lay_out(0, rows, nullptr, v, marks, grown);
}

// Makes the four views of Balancer, with multipliers and scales swapped or not.
__device__ void swap_views(const step::BalanceView& v, step::BalanceView* views) {
    for (int k = 0; k < 4; ++k) {
        views[k] = v;
        if (k & 1) views[k].multiplier = v.next_multiplier, views[k].next_multiplier = v.multiplier;
        if (k & 2) views[k].scale = v.next_scale, views[k].next_scale = v.scale;
    }
}

// Balances in shared memory: lays out the block's window, clears and fills it, and writes its rows back.
template <typename Communicator>
__device__ void balance_in_windows(const BalanceJob& job, Communicator& comm, int rows_per_block,
                                   char* memory) {
    __shared__ step::BalanceView views[4];
    __shared__ std::uint8_t* marks[2];
    step::BalanceView v = job.view;
    std::uint8_t *own_marks, *own_grown;
    const std::size_t bytes = lay_out(comm.first_row, rows_per_block, memory, v, own_marks, own_grown);
    for (std::size_t k = threadIdx.x; k < bytes / 4; k += blockDim.x) reinterpret_cast<float*>(memory)[k] = 0;
    if (threadIdx.x < 3) comm.scratch->flags[threadIdx.x] = 0;
    if (threadIdx.x == 0) {
        step::set_units(v, job.masses[0], job.masses[1], job.floor);
        swap_views(v, views);
        marks[0] = own_marks;
        marks[1] = own_grown;
    }
    __syncthreads();
    const int columns = v.lattice.columns;
    const int begin = max(comm.first_row - 1, 0) * columns,
              end = min(comm.last_row + 1, v.lattice.rows) * columns;
    for (int i = begin + threadIdx.x; i < end; i += blockDim.x) {
        views[0].x[i] = job.view.x[i];
        views[0].y[i] = job.view.y[i];
    }
    comm.wait();
    Balancer<Communicator, true>(job, views, marks[0], marks[1], comm).work();
    for (int i = comm.first_row * columns + threadIdx.x; i < comm.last_row * columns; i += blockDim.x) {
        job.view.x[i] = views[0].x[i];
        job.view.y[i] = views[0].y[i];
    }
    comm.wait();  // no block may end while another writes into its shared memory
}

extern __shared__ char memory[];

__global__ void __launch_bounds__(kBlock, 1) block_kernel(const __grid_constant__ BalanceJob job) {
    __shared__ SharedScratch scratch;
    if (job.masses[0] == 0) return;
    if (blockIdx.x > 0) return help(job, 1, blockIdx.x - 1, gridDim.x - 1);
    const int rows = job.view.lattice.rows;
    BlockCommunicator comm{0,
                           rows,
                           static_cast<int>(threadIdx.x),
                           static_cast<int>(blockDim.x),
                           &scratch,
                           {job.signals, gridDim.x - 1, 0}};
    balance_in_windows(job, comm, rows, memory);
}

__global__ void __launch_bounds__(kBlock, 1)
    cluster_kernel(const __grid_constant__ BalanceJob job, int blocks, int rows_per_block) {
#if __CUDA_ARCH__ >= 900
    __shared__ SharedScratch scratch;
    if (job.masses[0] == 0) return;
    const int rows = job.view.lattice.rows, block = blockIdx.x, first = block * rows_per_block;
    const int helpers = gridDim.x - blocks;  // helpers run in clusters of their own
    if (block >= blocks) return help(job, blocks, block - blocks, helpers);
    ClusterCommunicator comm{first,
                             max(first, min(first + rows_per_block, rows)),
                             static_cast<int>(threadIdx.x),
                             static_cast<int>(blockDim.x),
                             &scratch,
                             {job.signals, static_cast<std::uint32_t>(helpers), 0},
                             block,
                             blocks,
                             rows_per_block,
                             0,
                             0,
                             0};
    const auto distance = [&](int other) {
        return reinterpret_cast<char*>(ClusterCommunicator::of_block(&scratch, other)) -
               reinterpret_cast<char*>(&scratch);
    };
    if (block > 0) comm.to_previous = distance(block - 1);
    if (block + 1 < comm.blocks) comm.to_next = distance(block + 1);
    balance_in_windows(job, comm, rows_per_block, memory);
#endif
}

template <bool kResident>
__global__ void __launch_bounds__(kBlock, 1) grid_kernel(const __grid_constant__ BalanceJob job) {
    __shared__ SharedScratch scratch;
    __shared__ step::BalanceView views[4];
    if (job.masses[0] == 0) return;
    if (threadIdx.x == 0) {
        step::BalanceView v = job.view;
        step::set_units(v, job.masses[0], job.masses[1], job.floor);
        swap_views(v, views);
    }
    __syncthreads();
    GridCommunicator comm{0,
                          job.view.lattice.rows,
                          static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x),
                          static_cast<int>(gridDim.x * blockDim.x),
                          &scratch,
                          job.sums,
                          job.flags,
                          0};
    Balancer<GridCommunicator, kResident>(job, views, job.marks, job.grown, comm).work();
}

// Computes row-wise integrals of the density, with one warp per row. The sums are integers below 2^53, so
// doubles hold them exactly.
__global__ void integrate_kernel(const float* density, int width, int height, const std::uint32_t* largest,
                                 double* primitive, std::int64_t* masses) {
    const int row = (blockIdx.x * blockDim.x + threadIdx.x) / 32, lane = threadIdx.x % 32;
    const float most = __uint_as_float(*largest);
    if (row >= height || !(most > 0)) return;
    const double scale = step::mass_scale(most);
    const float* const from = density + static_cast<std::size_t>(row) * width;
    double* const to = primitive + static_cast<std::size_t>(row) * (width + 1);
    if (lane == 0) to[0] = 0;
    std::int64_t sum = 0, filled = 0;
    for (int first = 0; first < width; first += 32) {
        const int x = first + lane;
        std::int64_t mass = x < width ? step::whole_mass(from[x], scale) : 0;
        filled += mass > 0;
        for (int step = 1; step < 32; step *= 2) {
            const std::int64_t before = __shfl_up_sync(0xFFFFFFFFu, mass, step);
            if (lane >= step) mass += before;
        }
        if (x < width) to[x + 1] = static_cast<double>(sum + mass);
        sum += __shfl_sync(0xFFFFFFFFu, mass, 31);
    }
    filled = sum_of_warp(filled);
    if (lane != 0) return;
    atomicAdd(reinterpret_cast<unsigned long long*>(&masses[0]), static_cast<unsigned long long>(sum));
    atomicAdd(reinterpret_cast<unsigned long long*>(&masses[1]), static_cast<unsigned long long>(filled));
}

// Number of cell slots in `rows` rows.
int cells_of(const step::BalanceView& view, int rows) {
    return rows * view.slots;
}

// Returns the number of rows of each block if a cluster holds the level, else 0.
int cluster_rows(const Launch& launch, const step::BalanceView& view) {
    const int rows = view.lattice.rows;
    if (launch.cluster_blocks == 0 || rows * view.lattice.columns > kMostClusterVertices) return 0;
    const int per_block = std::max(2, (rows + launch.cluster_blocks - 1) / launch.cluster_blocks);
    return cells_of(view, per_block) <= kBlock && shared_bytes(view, per_block) <= kSharedLimit ? per_block
                                                                                                : 0;
}

// True if a single block holds the level.
bool fits_block(const Launch& launch, const step::BalanceView& view) {
    const int rows = view.lattice.rows;
    return launch.multiprocessors > 1 && cells_of(view, rows) <= kBlock &&
           rows * view.lattice.columns <= kMostBlockVertices && shared_bytes(view, rows) <= kSharedLimit;
}

void allow_shared_memory(const void* kernel) {
    check(cudaFuncSetAttribute(kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, kSharedLimit),
          "allowing shared memory");
}

// A launch of blocks that all run at once, in clusters of `cluster_blocks` if these are more than 1.
class CooperativeLaunch {
  public:
    CooperativeLaunch(cudaStream_t stream, int blocks, int cluster_blocks, std::size_t shared_bytes) {
        attributes_[0].id = cudaLaunchAttributeCooperative;
        attributes_[0].val.cooperative = 1;
        attributes_[1].id = cudaLaunchAttributeClusterDimension;
        attributes_[1].val.clusterDim = {static_cast<unsigned>(cluster_blocks), 1, 1};
        config_.gridDim = dim3(blocks);
        config_.blockDim = dim3(kBlock);
        config_.dynamicSmemBytes = shared_bytes;
        config_.stream = stream;
        config_.attrs = attributes_;
        config_.numAttrs = cluster_blocks > 1 ? 2 : 1;
    }
    CooperativeLaunch(const CooperativeLaunch&) = delete;
    CooperativeLaunch& operator=(const CooperativeLaunch&) = delete;

    const cudaLaunchConfig_t& config() const { return config_; }
    template <typename... Arguments>
    void run(const void* kernel, const char* what, Arguments... arguments) const {
        void* pointers[] = {&arguments...};
        check(cudaLaunchKernelExC(&config_, kernel, pointers), what);
    }

  private:
    cudaLaunchAttribute attributes_[2] = {};
    cudaLaunchConfig_t config_ = {};
};

void balance_in_block(const Launch& launch, const BalanceJob& job) {
    const auto kernel = reinterpret_cast<const void*>(block_kernel);
    allow_shared_memory(kernel);
    CooperativeLaunch(launch.stream, launch.multiprocessors, 1, shared_bytes(job.view, job.view.lattice.rows))
        .run(kernel, "balancing in a block", job);
}

void balance_in_cluster(const Launch& launch, const BalanceJob& job, int rows_per_block) {
    const auto kernel = reinterpret_cast<const void*>(cluster_kernel);
    allow_shared_memory(kernel);
    check(cudaFuncSetAttribute(kernel, cudaFuncAttributeNonPortableClusterSizeAllowed, 1),
          "allowing large clusters");
    int blocks = 1;
    while (blocks * rows_per_block < job.view.lattice.rows) blocks *= 2;
    const int clusters = launch.clusters * (launch.cluster_blocks / blocks);
    CooperativeLaunch(launch.stream, blocks * clusters, blocks, shared_bytes(job.view, rows_per_block))
        .run(kernel, "balancing in a cluster", job, blocks, rows_per_block);
}

void balance_in_grid(const Launch& launch, const BalanceJob& job) {
    const bool resident = cells_of(job.view, job.view.lattice.rows) <= launch.multiprocessors * kBlock;
    const auto kernel = resident ? reinterpret_cast<const void*>(grid_kernel<true>)
                                 : reinterpret_cast<const void*>(grid_kernel<false>);
    const std::size_t plane = static_cast<std::size_t>(step::cell_plane(job.view)) * sizeof(float);
    check(cudaMemsetAsync(job.view.multiplier, 0, plane, launch.stream), "clearing multipliers");
    check(cudaMemsetAsync(job.view.next_multiplier, 0, plane, launch.stream), "clearing multipliers");
    check(cudaMemsetAsync(job.sums, 0, 3 * sizeof(step::BalanceSums), launch.stream), "clearing sums");
    check(cudaMemsetAsync(job.flags, 0, 3 * sizeof(int), launch.stream), "clearing flags");
    CooperativeLaunch(launch.stream, launch.multiprocessors, 1, 0).run(kernel, "balancing in a grid", job);
}

}  // namespace

ClusterCapacity cluster_capacity() {
    int device = 0, major = 0;
    check(cudaGetDevice(&device), "asking for the device");
    check(cudaDeviceGetAttribute(&major, cudaDevAttrComputeCapabilityMajor, device),
          "asking for the architecture");
    if (major < 9) return {0, 0};
    const bool allowed = cudaFuncSetAttribute(cluster_kernel, cudaFuncAttributeNonPortableClusterSizeAllowed,
                                              1) == cudaSuccess &&
                         cudaFuncSetAttribute(cluster_kernel, cudaFuncAttributeMaxDynamicSharedMemorySize,
                                              kSharedLimit) == cudaSuccess;
    for (int blocks = allowed ? 16 : 0; blocks >= 8; blocks /= 2) {
        const CooperativeLaunch one_cluster(nullptr, blocks, blocks, kSharedLimit);
        int clusters = 0;
        if (cudaOccupancyMaxActiveClusters(&clusters, cluster_kernel, &one_cluster.config()) == cudaSuccess &&
            clusters > 1)
            return {blocks, clusters};
    }
    cudaGetLastError();  // clears the error: a refusal above is not a failure
    return {0, 0};
}

BalanceBuffers take_balance_buffers(const Launch& launch, Arena& arena,
                                    const std::vector<som::LevelPlan>& plans) {
    BalanceBuffers buffers{};
    const som::LevelPlan& finest = plans.back();
    buffers.primitive = arena.take<double>(static_cast<std::size_t>(finest.width + 1) * finest.height);
    buffers.totals = arena.take<BalanceTotals>(plans.size());
    BalanceJob& job = buffers.grid;
    job.view = balance::balance_view(finest, BalanceConfig{}, false);
    step::BalanceView& v = job.view;
    const std::size_t vertices = static_cast<std::size_t>(v.lattice.columns) * v.lattice.rows,
                      cells = cells_of(v, v.lattice.rows), plane = step::cell_plane(v);
    v.edges = arena.take<step::EdgeMass>(3 * cells);
    v.right_flux = arena.take<double>(v.lattice.rows);
    v.end_flux = arena.take<double>(static_cast<std::size_t>(2) * v.lattice.columns);
    if (fits_block(launch, v) || cluster_rows(launch, v)) return buffers;
    for (float** array : {&v.inverse_xx, &v.inverse_xy, &v.inverse_yy, &v.reach, &v.step_x, &v.step_y,
                          &v.scale, &v.next_scale})
        *array = arena.take<float>(vertices);
    v.gradient_x = arena.take<float>(3 * vertices);
    v.gradient_y = arena.take<float>(3 * vertices);
    v.multiplier = arena.take<float>(plane);
    v.next_multiplier = arena.take<float>(plane);
    job.equations = arena.take<step::CellEquation>(cells);
    job.directions = arena.take<float>(cells);
    job.marks = arena.take<std::uint8_t>(vertices);
    job.grown = arena.take<std::uint8_t>(vertices);
    job.sums = arena.take<step::BalanceSums>(3);
    job.flags = arena.take<int>(3);
    return buffers;
}

void integrate_rows(const Launch& launch, const BalanceBuffers& buffers, const som::LevelPlan& plan,
                    int index, const float* density) {
    const std::size_t pixels = static_cast<std::size_t>(plan.width) * plan.height;
    BalanceTotals& totals = buffers.totals[index];
    check(cudaMemsetAsync(&totals, 0, sizeof totals, launch.stream), "clearing sums");
    find_largest(launch, density, pixels, &totals.largest);
    integrate_kernel<<<blocks_for(plan.height, 4), 128, 0, launch.stream>>>(
        density, plan.width, plan.height, &totals.largest, buffers.primitive, totals.masses);
    check_launch("integrating the density");
}

void balance(const Launch& launch, const BalanceBuffers& buffers, const som::LevelPlan& plan, int index,
             const BalanceConfig& config, const LevelView& level) {
    BalanceJob job = buffers.grid;
    const step::BalanceView plain = balance::balance_view(plan, config, level.pinned);
    job.view.lattice = plain.lattice;
    job.view.extent_x = plain.extent_x;
    job.view.extent_y = plain.extent_y;
    job.view.pinned = plain.pinned;
    job.view.outline = level.outline;
    job.view.slots = plain.slots;
    job.view.stride = plain.stride;
    job.view.threshold = plain.threshold;
    job.view.least_threshold = plain.least_threshold;
    job.view.most_threshold = plain.most_threshold;
    job.view.thin_sine2 = plain.thin_sine2;
    job.view.width = plain.width;
    job.view.height = plain.height;
    job.view.primitive = buffers.primitive;
    job.view.x = level.x;
    job.view.y = level.y;
    job.masses = buffers.totals[index].masses;
    job.signals = &buffers.totals[index].signals;
    job.floor = config.floor;
    job.limits = balance::balance_limits(config, plan.level);
    job.full_cells = balance::full_cells(plan.lattice);
    if (job.full_cells == 0) return;
    const std::vector<balance::SweepGain> gains = balance::chebyshev_gains(config.sweeps);
    job.sweeps = static_cast<int>(gains.size());
    if (job.sweeps > kMostSweeps)
        throw Error(ErrorKind::usage,
                    "mesh.balance.sweeps: at most " + std::to_string(kMostSweeps) + " with --backend cuda");
    std::copy(gains.begin(), gains.end(), job.gains);
    if (fits_block(launch, job.view)) {
        balance_in_block(launch, job);
    } else if (const int rows_per_block = cluster_rows(launch, job.view)) {
        balance_in_cluster(launch, job, rows_per_block);
    } else {
        balance_in_grid(launch, job);
    }
}

}  // namespace hexrelief::cuda
