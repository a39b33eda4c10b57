// Assigns vertices, edges and cells of a lattice to threads, and stores the cells' equations.
// Included only by iteration.cuh.
#pragma once

#include <cstdint>

#include "cuda/balance/balance.h"
#include "mesher/balance/cell_equations_step.h"

namespace hexrelief::cuda {

// A vertex of the lattice, or an item of a row.
struct LatticeIndex {
    int column, row;
};

// Division by a constant of the run. kSmall: the dividends are below 65536, so it is done by multiplication.
template <bool kSmall>
struct Divisor {
    int by;
    std::uint32_t factor;

    __device__ explicit Divisor(int d) : by(d), factor(d > 1 ? 0xFFFFFFFFu / d + 1 : 0) {}
    __device__ int operator()(int n) const {
        if constexpr (kSmall) return by > 1 ? __umulhi(n, factor) : n;
        return n / by;
    }
};

// `width` items in each of the rows [first, first + rows).
template <bool kSmall>
struct RowItems {
    int first, count;
    Divisor<kSmall> width;

    __device__ RowItems(int first_row, int rows, int items_a_row)
        : first(first_row), count(rows * items_a_row), width(items_a_row) {}
    __device__ LatticeIndex at(int item) const {
        const int row = width(item);
        return {item - row * width.by, first + row};
    }
};

// Column of the slot-th vertex of a class in a row; it may lie beyond the last column.
__device__ __forceinline__ int column_of_class(int slot, int row, int of_class) {
    return (of_class + row + row / 2) % 3 + 3 * slot;
}

// A cell, its slot and its neighbours' offsets in the array of multipliers; held: is_held_cell().
struct CellItem {
    LatticeIndex at;
    int item, slot;
    step::CellRing ring;
    bool held;
};

// The equations of a thread's cells: in registers if it has at most one cell, else in memory.
template <bool kResident>
struct Equations;

template <>
struct Equations<true> {
    step::CellEquation equation;
    float direction;
    __device__ explicit Equations(const BalanceJob&) : equation{}, direction(0) {}
    __device__ step::CellEquation& at(int) { return equation; }
    __device__ float& direction_at(int) { return direction; }
};

template <>
struct Equations<false> {
    step::CellEquation* equations;
    float* directions;
    __device__ explicit Equations(const BalanceJob& job)
        : equations(job.equations), directions(job.directions) {}
    __device__ step::CellEquation& at(int item) { return equations[item]; }
    __device__ float& direction_at(int item) { return directions[item]; }
};

}  // namespace hexrelief::cuda
