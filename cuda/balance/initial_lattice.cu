#include "cuda/balance/balance.h"
#include "cuda/common/check.h"
#include "mesher/balance/cell_equations_step.h"
#include "mesher/balance/initial_lattice_step.h"
#include "mesher/som/level_transfer_step.h"

namespace hexrelief::cuda {
namespace {

constexpr int kBlock = 128;
constexpr int kRows = 16;  // rows of the density that a block adds up

// Masses by columns and by rows, later their prefix sums.
struct Margins {
    std::int64_t *columns, *rows;  // width + 1, height + 1 entries, the first 0
    int width, height;
};

// Adds up the masses of columns and rows, into the entries after the first.
__global__ void add_kernel(const float* density, const std::uint32_t* largest, Margins m) {
    const float most = __uint_as_float(*largest);
    if (!(most > 0)) return;
    const double scale = step::mass_scale(most);
    const int x = blockIdx.x * kBlock + threadIdx.x, first = blockIdx.y * kRows;
    std::int64_t sum = 0;
    for (int y = first; y < min(first + kRows, m.height); ++y) {
        std::int64_t mass =
            x < m.width ? step::whole_mass(density[static_cast<std::size_t>(y) * m.width + x], scale) : 0;
        sum += mass;
        for (int other = 16; other > 0; other /= 2) mass += __shfl_xor_sync(0xFFFFFFFFu, mass, other);
        if (threadIdx.x % 32 == 0)
            atomicAdd(reinterpret_cast<unsigned long long*>(&m.rows[y + 1]),
                      static_cast<unsigned long long>(mass));
    }
    if (x < m.width)
        atomicAdd(reinterpret_cast<unsigned long long*>(&m.columns[x + 1]),
                  static_cast<unsigned long long>(sum));
}

// Turns masses into prefix sums, with the evenly spread mass added to each entry; by one warp.
__device__ void accumulate(std::int64_t* sums, int count) {
    const int lane = threadIdx.x % 32;
    std::int64_t total = 0;
    for (int k = lane; k < count; k += 32) total += sums[k + 1];
    for (int other = 16; other > 0; other /= 2) total += __shfl_xor_sync(0xFFFFFFFFu, total, other);
    const std::int64_t even = step::even_mass(total, count);
    std::int64_t before = 0;
    for (int first = 0; first < count; first += 32) {
        const int k = first + lane;
        std::int64_t sum = k < count ? sums[k + 1] + even : 0;
        for (int other = 1; other < 32; other *= 2) {
            const std::int64_t below = __shfl_up_sync(0xFFFFFFFFu, sum, other);
            if (lane >= other) sum += below;
        }
        if (k < count) sums[k + 1] = before + sum;
        before += __shfl_sync(0xFFFFFFFFu, sum, 31);
    }
}

__global__ void accumulate_kernel(Margins m) {
    if (threadIdx.x < 32)
        accumulate(m.columns, m.width);
    else
        accumulate(m.rows, m.height);
}

__global__ void place_kernel(LevelView level, Margins m) {
    const int i = blockIdx.x * kBlock + threadIdx.x, columns = level.lattice.columns;
    if (i >= columns * level.lattice.rows) return;
    const int column = i % columns, row = i / columns;
    float x = step::regular_x(column, row, columns, level.extent_x);
    float y = step::regular_y(row, level.lattice.rows, level.extent_y);
    if (m.columns[m.width] > 0) {
        x = step::equalised(m.columns, m.width, x / level.extent_x, level.extent_x);
        y = step::equalised(m.rows, m.height, y / level.extent_y, level.extent_y);
        step::bend_start(border_of(level), column, row, x, y);
    }
    if (level.pinned) step::pin_to_border(border_of(level), column, row, x, y);
    level.x[i] = x;
    level.y[i] = y;
}

}  // namespace

std::size_t start_sums(const som::LevelPlan& plan) {
    return static_cast<std::size_t>(plan.width) + plan.height + 2;
}

void place_equalised(const Launch& launch, const LevelView& level, const som::LevelPlan& plan,
                     const float* density, const std::uint32_t* largest, std::int64_t* sums) {
    const Margins margins{sums, sums + plan.width + 1, plan.width, plan.height};
    check(cudaMemsetAsync(sums, 0, start_sums(plan) * sizeof(std::int64_t), launch.stream), "clearing sums");
    const dim3 blocks(blocks_for(plan.width, kBlock), blocks_for(plan.height, kRows));
    add_kernel<<<blocks, kBlock, 0, launch.stream>>>(density, largest, margins);
    accumulate_kernel<<<1, 64, 0, launch.stream>>>(margins);
    const std::size_t vertices = static_cast<std::size_t>(level.lattice.columns) * level.lattice.rows;
    place_kernel<<<blocks_for(vertices, kBlock), kBlock, 0, launch.stream>>>(level, margins);
    check_launch("placing the lattice");
}

}  // namespace hexrelief::cuda
