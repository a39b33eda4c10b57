// Which thread works on which vertex, edge or cell of a lattice, and where a cell's equation is kept.
// Included by balance_steps.cuh only.
#pragma once

#include <cstdint>

#include "cuda/balance.h"
#include "mesher/steps/balance_cells.h"

namespace hexrelief::cuda {

// A lattice vertex; inner: it has six neighbours. row -1: none.
struct Place {
    int column, row;
    bool inner;
};

// Division by a constant of the run. kSmall: of less than 65536, as a multiplication.
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

// The vertices of rows [first, last), or those of one class, in an order that keeps those of the lattice's
// border apart, so that warps do not take both ways.
template <bool kSmall>
struct VertexOrder {
    int columns, rows, stride, of_class;  // stride 1: all; 3: of one class
    int first, inner_rows, inner_count, padded, top, bottom, count;
    Divisor<kSmall> inner_columns;

    __device__ VertexOrder(const step::Lattice& lattice, int first_row, int last_row, int class_stride)
        : columns(lattice.columns),
          rows(lattice.rows),
          stride(class_stride),
          of_class(0),
          first(max(first_row, 1)),
          inner_rows(max(0, min(last_row, lattice.rows - 1) - first)),
          inner_columns(class_stride == 1 ? lattice.columns - 2 : (lattice.columns + 2) / 3) {
        const int width = class_stride == 1 ? columns : inner_columns.by;
        inner_count = inner_rows * inner_columns.by;
        padded = (inner_count + 31) / 32 * 32;
        top = first_row == 0 && last_row > 0 ? width : 0;
        bottom = last_row == rows && last_row > first_row ? width : 0;
        count = padded + top + bottom + 2 * inner_rows;
    }
    // First column of the class in a row.
    __device__ static int first_column(int row, int of_class) { return (of_class + row + row / 2) % 3; }

    __device__ Place at(int item) const { return at(item, 0); }
    __device__ Place at(int item, int of_class) const {
        constexpr Place kNone{0, -1, false};
        if (item < inner_count) {
            const int local = inner_columns(item), k = item - local * inner_columns.by, row = first + local;
            if (stride == 1) return {1 + k, row, true};
            const int start = first_column(row, of_class), column = (start > 0 ? start : 3) + 3 * k;
            return column < columns - 1 ? Place{column, row, true} : kNone;
        }
        int k = item - padded;
        if (k < 0 || item >= count) return kNone;
        if (k < top + bottom) {
            const int row = k < top ? 0 : rows - 1;
            if (k >= top) k -= top;
            const int column = stride == 1 ? k : first_column(row, of_class) + 3 * k;
            return column < columns ? Place{column, row, false} : kNone;
        }
        k -= top + bottom;
        const int row = first + k / 2, column = k & 1 ? columns - 1 : 0;
        const bool there = stride == 1 || (column - first_column(row, of_class)) % 3 == 0;
        return there ? Place{column, row, false} : kNone;
    }
};

// A cell whose weight is held, and where its multiplier and those around it stand.
struct CellPlace {
    Place place;
    int item, slot;
    step::CellRing ring;
    bool held;
};

// The equations of a thread's cells: in registers where it has at most one, else in memory.
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
