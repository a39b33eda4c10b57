// Device functions of one iteration in distributed shared memory. Included by som_cluster.cu only.
#pragma once

#include <cub/block/block_scan.cuh>

#include "cuda/som_steps.cuh"

namespace hexrelief::cuda {

constexpr int kBlock = 704;  // leaves 93 registers a thread: nothing spills
constexpr int kLearnWarps = 10, kSearchWarps = kBlock / 32 - kLearnWarps;  // work side by side
constexpr int kTileColumns = 8, kTileRows = 4;                             // neurons of a learning warp

// A neuron's handle: block that owns its row << 16 | index within the block's rows. Handles order like the
// neurons. A won point as the blocks tell it each other: row << 16 | axial q, and y << 16 | x of the point in
// half px.
struct Won {
    std::uint32_t place, point;
};

// Shared memory of a block: its own rows' positions, its own copy of the cell lists, and the points won near
// its rows.
struct Shared {
    float2* home[2];           // rows_per_block * columns: at the start of this iteration and of the next
    std::uint32_t* begin;      // cells + 1
    std::uint32_t* count;      // cells
    std::uint32_t* ids;        // neurons: handles in the order of their cells
    std::uint32_t* sorting;    // neurons: cell << 16 | place within the cell
    Won* won[2];               // of this iteration and the next, in any order
    std::uint32_t* won_count;  // three, used in turn: read, added to, cleared
    Won* tile;                 // kLearnWarps * kTileUnits
    uint2* tables[2];          // kTableWidth: gain and fall of each distance, 0 beyond the radius
};
constexpr int kTileUnits = 64;

__host__ __device__ inline int rows_per_block(const LevelView& level, int blocks) {
    const int rows = (level.lattice.rows + blocks - 1) / blocks;
    return (rows + kTileRows - 1) / kTileRows * kTileRows;
}

// Lays the arrays out from base on; returns the bytes.
__host__ __device__ inline std::size_t lay_out(const LevelView& level, int blocks, char* base,
                                               Shared* shared) {
    std::size_t used = 0;
    const auto take = [&](auto*& pointer, std::size_t count) {
        using T = std::remove_reference_t<decltype(*pointer)>;
        pointer = reinterpret_cast<T*>(base + used);
        used += (count * sizeof(T) + 15) / 16 * 16;
    };
    const std::size_t neurons = static_cast<std::size_t>(level.lattice.columns) * level.lattice.rows;
    const std::size_t cells = static_cast<std::size_t>(level.grid.columns) * level.grid.rows;
    for (int k = 0; k < 2; ++k) {
        take(shared->home[k],
             static_cast<std::size_t>(rows_per_block(level, blocks)) * level.lattice.columns);
        take(shared->won[k], level.point_capacity);
        take(shared->tables[k], kTableWidth);
    }
    take(shared->begin, cells + 1);
    take(shared->count, cells);
    take(shared->ids, neurons);
    take(shared->sorting, neurons);
    take(shared->won_count, 3);
    take(shared->tile, kLearnWarps * kTileUnits);
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
    asm volatile(
        "ld.shared::cluster.v2.f32 {%0, %1}, [%2];"
        : "=f"(at.x), "=f"(at.y)
        : "r"(address_in(home_address + (handle & 0xFFFFu) * static_cast<std::uint32_t>(sizeof(float2)),
                         handle >> 16)));
    return at;
}

// Appends to another block's list of points won.
__device__ __forceinline__ void tell(std::uint32_t won_address, std::uint32_t count_address,
                                     std::uint32_t block, const Won& won) {
    std::uint32_t slot;
    asm volatile("atom.shared::cluster.add.u32 %0, [%1], 1;"
                 : "=r"(slot)
                 : "r"(address_in(count_address, block))
                 : "memory");
    asm volatile("st.shared::cluster.v2.u32 [%0], {%1, %2};" ::"r"(
                     address_in(won_address + slot * static_cast<std::uint32_t>(sizeof(Won)), block)),
                 "r"(won.place), "r"(won.point)
                 : "memory");
}

__device__ __forceinline__ void wait_for_cluster() {
    asm volatile("barrier.cluster.arrive.release.aligned;\n\tbarrier.cluster.wait.acquire.aligned;" ::
                     : "memory");
}

// The paper's refresh, by every block for itself: all neurons sorted into cells.
__device__ void refresh_cells(const LevelView& level, const Shared& shared, std::uint32_t home_address,
                              int owned) {
    using Scan = cub::BlockScan<std::uint32_t, kBlock>;
    __shared__ typename Scan::TempStorage scan_storage;
    const int neurons = level.lattice.columns * level.lattice.rows,
              cells = level.grid.columns * level.grid.rows;
    const int blocks = gridDim.x;
    for (int c = threadIdx.x; c < cells; c += kBlock) shared.count[c] = 0;
    __syncthreads();
    constexpr int kAtOnce = 4;  // loads under way from other blocks
    // each block starts with its own rows: were all to ask the same block at once, a refresh would take ten
    // times as long
    const auto owner_of = [&](int k) { return (k + static_cast<int>(blockIdx.x)) % blocks; };
    for (int first = 0; first < owned; first += kBlock) {
        const int index = first + threadIdx.x;
        for (int owner0 = 0; owner0 < blocks; owner0 += kAtOnce) {
            float2 at[kAtOnce];
#pragma unroll
            for (int k = 0; k < kAtOnce; ++k)
                if (owner0 + k < blocks && index < owned)
                    at[k] = load_position(home_address, owner_of(owner0 + k) << 16 | index);
#pragma unroll
            for (int k = 0; k < kAtOnce; ++k) {
                const int i = owner_of(owner0 + k) * owned + index;
                const bool valid = owner0 + k < blocks && index < owned && i < neurons;
                const int cell = valid ? step::cell_of(level.grid, at[k].x, at[k].y) : -1;
                const std::uint32_t place = count_in_cell(shared.count, cell);
                if (valid) shared.sorting[i] = static_cast<std::uint32_t>(cell) << 16 | place;
            }
        }
    }
    __syncthreads();
    std::uint32_t before = 0;
    for (int first = 0; first < cells; first += kBlock) {
        const int c = first + threadIdx.x;
        std::uint32_t start, total;
        Scan(scan_storage).ExclusiveSum(c < cells ? shared.count[c] : 0u, start, total);
        if (c < cells) shared.begin[c] = before + start;
        before += total;
        __syncthreads();
    }
    if (threadIdx.x == 0) shared.begin[cells] = before;
    __syncthreads();
    for (int index = threadIdx.x; index < owned; index += kBlock)
#pragma unroll 4
        for (int owner = 0; owner < blocks; ++owner) {
            const int i = owner * owned + index;
            if (i >= neurons) break;
            const std::uint32_t sorting = shared.sorting[i];
            shared.ids[shared.begin[sorting >> 16] + (sorting & 0xFFFFu)] = owner << 16 | index;
        }
    __syncthreads();
}

// step::spiral_search by a group of lanes; returns the handle of the best matching unit. The distances to
// cells are those of step::cell_distance: all terms are multiples of a quarter pixel, so every way to compute
// them is exact.
template <int kLanes>
__device__ __forceinline__ std::uint32_t search(const LevelView& level, const Shared& shared,
                                                std::uint32_t home_address, std::uint32_t point, bool active,
                                                int lane) {
    const step::CellGrid& grid = level.grid;
    const int hx = point & 0xFFFFu, hy = point >> 16;
    const float px = static_cast<float>(hx) * 0.5f, py = static_cast<float>(hy) * 0.5f;
    const int cx = __umulhi(hx, level.cell_factor), cy = __umulhi(hy, level.cell_factor),
              cell = cy * grid.columns + cx;
    std::uint64_t best = candidate_key(step::Candidate{}.squared_distance, step::Candidate{}.neuron);
    constexpr int kAtOnce = 3;                                           // loads under way a lane
    const auto consider = [&](std::uint32_t count, const auto& index) {  // index(k) for k in [0, count)
        for (std::uint32_t k0 = lane; k0 < count; k0 += kAtOnce * kLanes) {
            std::uint32_t handle[kAtOnce];
            float2 at[kAtOnce];
#pragma unroll
            for (int j = 0; j < kAtOnce; ++j) {
                handle[j] =
                    shared.ids[index(min(k0 + j * kLanes, count - 1))];  // the last one again beyond the end
                at[j] = load_position(home_address, handle[j]);
            }
#pragma unroll
            for (int j = 0; j < kAtOnce; ++j) {
                const float dx = at[j].x - px, dy = at[j].y - py;
                const std::uint64_t key = candidate_key(dx * dx + dy * dy, handle[j]);
                best = key < best ? key : best;
            }
        }
    };
    const std::uint32_t own_begin = shared.begin[cell], own_end = shared.begin[cell + 1];
    if (active) consider(own_end - own_begin, [&](std::uint32_t k) { return own_begin + k; });
    best = least_of_group<kLanes>(best);

    float reach = key_distance(best);
    const float left = px - static_cast<float>(cx * grid.co),
                right = static_cast<float>((cx + 1) * grid.co) - px;
    const float up = py - static_cast<float>(cy * grid.co),
                down = static_cast<float>((cy + 1) * grid.co) - py;
    const float left2 = left * left, right2 = right * right;
    const bool west = cx > 0 && !(left2 > reach), east = cx + 1 < grid.columns && !(right2 > reach);
    const bool north = cy > 0 && !(up * up > reach), south = cy + 1 < grid.rows && !(down * down > reach);
    bool searching = active && !(step::ring_distance(grid, cx, cy, 1, px, py) > reach);
    if (__any_sync(kAllLanes, searching)) {
        std::uint32_t begin[4] = {},
                      count[4] = {};  // the row above, the row below, the cells to the left and to the right
        if (searching) {
#pragma unroll
            for (int side = 0; side < 2; ++side) {
                if (!(side ? south : north)) continue;
                const float across = side ? down * down : up * up;
                const int middle = side ? cell + grid.columns : cell - grid.columns;
                begin[side] = shared.begin[middle - (west && !(left2 + across > reach))];
                count[side] = shared.begin[middle + 1 + (east && !(right2 + across > reach))] - begin[side];
            }
            if (west) {
                begin[2] = shared.begin[cell - 1];
                count[2] = own_begin - begin[2];
            }
            if (east) {
                begin[3] = own_end;
                count[3] = shared.begin[cell + 2] - own_end;
            }
        }
        const std::uint32_t upto0 = count[0], upto1 = upto0 + count[1], upto2 = upto1 + count[2];
        consider(upto2 + count[3], [&](std::uint32_t k) {
            return k < upto0   ? begin[0] + k
                   : k < upto1 ? begin[1] + (k - upto0)
                   : k < upto2 ? begin[2] + (k - upto1)
                               : begin[3] + (k - upto2);
        });
        best = least_of_group<kLanes>(best);
    }
    const int limit = step::ring_limit(grid, level.ssr);
    for (int ring = 2;; ++ring) {
        reach = key_distance(best);
        searching = searching && ring <= limit && !(step::ring_distance(grid, cx, cy, ring, px, py) > reach);
        if (!__any_sync(kAllLanes, searching)) break;
        if (searching)
            for (int k = lane; k < 8 * ring;
                 k += kLanes) {  // a lane a cell of the ring: most are empty this far out
                int u, v;
                step::ring_cell(ring, k, u, v);
                u += cx;
                v += cy;
                if (u < 0 || u >= grid.columns || v < 0 || v >= grid.rows) continue;
                if (step::cell_distance(grid, u, v, px, py) > reach) continue;
                const int other = v * grid.columns + u;
                for (std::uint32_t i = shared.begin[other]; i < shared.begin[other + 1]; ++i) {
                    const float2 at = load_position(home_address, shared.ids[i]);
                    const float dx = at.x - px, dy = at.y - py;
                    const std::uint64_t key = candidate_key(dx * dx + dy * dy, shared.ids[i]);
                    best = key < best ? key : best;
                }
            }
        best = least_of_group<kLanes>(best);
    }
    return static_cast<std::uint32_t>(best);
}

struct Rows {  // of the lattice that the block owns
    int first, last, per_block;
};

// The triggering step of a tile of neurons by one warp from the block's list of points won, a lane a neuron.
__device__ __forceinline__ void learn_tile(const LevelView& level, const Rows& rows, const Won* won,
                                           std::uint32_t won_count, const uint2* tables, int radius,
                                           Won* list, int tile_column, int tile_row, const float2* positions,
                                           float2* next, int lane) {
    const int columns = level.lattice.columns;
    const int column = tile_column * kTileColumns + lane % kTileColumns;
    const int local_row = tile_row * kTileRows + lane / kTileColumns, row = rows.first + local_row;
    const int q = step::axial_q(column, row), i = local_row * columns + column;
    const int top = rows.first + tile_row * kTileRows - radius, height = kTileRows + 2 * radius;
    const int left = tile_column * kTileColumns - radius - 1, width = kTileColumns + 2 * radius + 2;
    const bool inside = column < columns && row <= rows.last;
    float2 at = inside ? positions[i] : float2{};
    step::Pull pull;
    int listed = 0;
    const auto add_all = [&] {
        __syncwarp();
#pragma unroll 4
        for (int k = 0; k < listed; ++k) {
            const Won unit = list[k];
            const int dq = static_cast<std::int16_t>(unit.place & 0xFFFFu) - q,
                      dr = static_cast<int>(unit.place >> 16) - row;
            const int distance = max(max(abs(dq), abs(dr)), abs(dq + dr));
            const uint2 table = tables[min(distance, kTableWidth - 1)];
            pull.gain += table.x;
            pull.x += table.x * (unit.point & 0xFFFFu);
            pull.y += table.x * (unit.point >> 16);
            pull.fall += table.y;
        }
        __syncwarp();
        listed = 0;
    };
    for (std::uint32_t base = 0; base < won_count; base += 32) {
        Won unit{};
        bool keep = false;
        if (base + lane < won_count) {
            unit = won[base + lane];
            const int unit_row = unit.place >> 16;
            const int unit_column = static_cast<std::int16_t>(unit.place & 0xFFFFu) + unit_row / 2;
            keep = static_cast<unsigned>(unit_row - top) < static_cast<unsigned>(height) &&
                   static_cast<unsigned>(unit_column - left) < static_cast<unsigned>(width);
        }
        const unsigned kept = __ballot_sync(kAllLanes, keep);
        if (listed + __popc(kept) > kTileUnits) add_all();
        if (keep) list[listed + __popc(kept & ((1u << lane) - 1))] = unit;
        listed += __popc(kept);
    }
    add_all();
    if (!inside) return;
    if (pull.gain) {
        step::learn(pull, level.extent_x, level.extent_y, at.x, at.y);
        if (level.pinned)
            step::pin_to_border(level.lattice, column, row, level.extent_x, level.extent_y, at.x, at.y);
    }
    next[i] = at;
}

#endif

}  // namespace hexrelief::cuda
