// Balancing: the linear system for the cells' Lagrange multipliers lambda, with one equation per cell; the
// Chebyshev sweeps that solve it (edge_integrals_step.h describes the method); and the level's density as
// integers, so that its row sums are exact in any order.
#pragma once

#include <cstdint>

#include "mesher/balance/edge_integrals_step.h"

namespace hexrelief::step {

// Larger multipliers would overflow in the triangles around the cell.
inline constexpr float kMostMultiplier = 1e18f;

// A cell's equation. residual: its right-hand side, to which close_equation() adds the target weight. across:
// the coefficients of the six cells around it; cell k lies beyond the boundary edge from vertex k to k + 1.
// inverse: 1 / the preconditioner.
struct CellEquation {
    float weight, residual, diagonal, inverse, across[6];
};

// Sets up the equation of the cell centred at (column, row). kFull selects a branch-free version for
// cells with six neighbours.
template <bool kFull>
HEXRELIEF_HD CellEquation cell_equation(const BalanceView& v, int column, int row) {
    const LatticeView m = lattice_view(v);
    const int i = row * m.columns + column;
    double flux = 0;
    float area2 = 0, moved = 0;
    CellEquation e = {0, 0, 0, 0, {0, 0, 0, 0, 0, 0}};
    HEXRELIEF_UNROLL
    for (int k = 0; k < 6; ++k) {
        const Neighbour na = neighbour_of(v, column, row, k), nb = neighbour_of(v, column, row, (k + 1) % 6);
        const int a = na.index;
        if (!kFull && !na.exists) continue;
        // Boundary edge a -> b has direction k + 2 from a; a is of class 1 if k is even.
        if (kFull || nb.exists) {
            const EdgeMass& edge = k % 2 == 0
                                       ? v.edges[3 * boundary_slot(v, na.column, na.row) + (k + 2) % 6 / 2]
                                       : v.edges[3 * boundary_slot(v, nb.column, nb.row) + (k + 5) % 6 / 2];
            flux += k % 2 == 0 ? edge.flux : -edge.flux;
            area2 += twice_area(m, i, a, nb.index);
        }
        // direction from a to this cell; its other two cells lie 2 and 4 directions further on
        const int back = (k + 3) % 6;
        const int first = 3 * a;
        const float *const gx = v.gradient_x + first, *const gy = v.gradient_y + first;
        const float x = gx[gradient_slot(back)], y = gy[gradient_slot(back)];
        const float hx = v.inverse_xx[a] * x + v.inverse_xy[a] * y,
                    hy = v.inverse_xy[a] * x + v.inverse_yy[a] * y;
        const int before = gradient_slot((back + 2) % 6), after = gradient_slot((back + 4) % 6);
        moved += x * v.step_x[a] + y * v.step_y[a];
        e.diagonal += x * hx + y * hy;
        e.across[(k + 5) % 6] += gx[before] * hx + gy[before] * hy;
        e.across[k] += gx[after] * hx + gy[after] * hy;
    }
    if (!kFull && is_bent(v.outline) && is_end(v.lattice, row)) {
        const double* const ends = v.end_flux + (row == 0 ? 0 : m.columns - 1);
        if (column > 0) flux += ends[column - 1];
        if (column + 1 < m.columns) flux += ends[column];
    }
    // Cells at the right border are held only if it is pinned: then their boundary ends on the area's border.
    if (!kFull && column == m.columns - 1) {
        if (row > 0) flux += v.right_flux[row - 1];
        if (row + 1 < m.rows) flux += v.right_flux[row];
    }
    e.weight = static_cast<float>(flux) + v.floor * 0.5f * area2;
    e.residual = -moved;
    return e;
}

// Returns the share of a whole cell that the cell's triangles within the lattice make up, a multiple of 1/6.
HEXRELIEF_HD float cell_share(const BalanceView& v, int column, int row) {
    const LatticeView m = lattice_view(v);
    float share = 0;
    HEXRELIEF_ROLLED
    for (int k = 0; k < 6; ++k)
        if (neighbour(m, column, row, k) >= 0 && neighbour(m, column, row, (k + 1) % 6) >= 0)
            share += 1.0f / 6.0f;
    return share;
}

// Completes the equation with the target weight. The preconditioner is the sum of the magnitudes of the
// equation's coefficients, so that all eigenvalues lie in (0, 1].
HEXRELIEF_HD void close_equation(const BalanceView& v, int column, int row, float target, CellEquation& e) {
    const bool full = is_full_cell(v.lattice, column, row);
    const float missing = target * (full ? 1.0f : cell_share(v, column, row)) - e.weight;
    const float deviation = missing < 0 ? -missing : missing;
    e.diagonal += full ? kElasticity * (1.0f + kElasticityGrowth * deviation) : kBorderElasticity;
    float sum = e.diagonal;
    for (int k = 0; k < 6; ++k) sum += e.across[k] < 0 ? -e.across[k] : e.across[k];
    e.residual = missing + e.residual;
    e.inverse = 1.0f / sum;
}

// Offsets in slot index from a cell to the six cells around it.
struct CellRing {
    int at[6];
};

// Returns the ring of the cells of a row; it is the same for all cells of that row.
HEXRELIEF_HD CellRing cell_ring(const BalanceView& v, int row) {
    const int odd = row & 1, first = honeycomb_class(0, row) == 0 ? 0 : honeycomb_class(1, row) == 0 ? 1 : 2;
    const int right = (first + 1 + odd) / 3, left = (first - 2 + odd + 3) / 3 - 1;
    return {
        {v.stride + right, 2 * v.stride, v.stride + left, left - v.stride, -2 * v.stride, right - v.stride}};
}

// Makes one Chebyshev sweep for a cell: direction = keep x direction + gain x preconditioned residual. `l`
// points to the cell's multiplier in the array of all multipliers. Returns the cell's next multiplier.
HEXRELIEF_HD float chebyshev_sweep(const CellEquation& e, const float* l, const CellRing& ring, float keep,
                                   float gain, float& direction) {
    const float r = e.residual - e.diagonal * l[0] - e.across[0] * l[ring.at[0]] -
                    e.across[1] * l[ring.at[1]] - e.across[2] * l[ring.at[2]] - e.across[3] * l[ring.at[3]] -
                    e.across[4] * l[ring.at[4]] - e.across[5] * l[ring.at[5]];
    direction = keep * direction + gain * (r * e.inverse);
    const float next = l[0] + direction;
    return next < kMostMultiplier && next > -kMostMultiplier ? next : 0.0f;
}

// bits of the densest pixel's mass; sums of 2^29 pixels fit into 64 bits
inline constexpr int kMassBits = 30;

// Returns the scale for whole_mass() on a level whose densest pixel holds `largest` > 0.
HEXRELIEF_HD double mass_scale(float largest) {
    return static_cast<double>(1 << kMassBits) / static_cast<double>(largest);
}

// Returns a pixel's density as an integer mass.
HEXRELIEF_HD std::int64_t whole_mass(float density, double scale) {
    return static_cast<std::int64_t>(static_cast<double>(density) * scale);
}

// Sets the units of a level with `total` > 0 mass in `filled` pixels, so that every cell's weight is 1 at
// perfect balance and empty pixels have floor_share of the filled pixels' mean.
HEXRELIEF_HD void set_units(BalanceView& v, std::int64_t total, std::int64_t filled, double floor_share) {
    const double mass = static_cast<double>(total);
    v.unit = (v.lattice.columns - 1.0) * (v.lattice.rows - 1.0) / (3 * mass);
    v.floor = static_cast<float>(floor_share * mass / static_cast<double>(filled) * v.unit);
}

}  // namespace hexrelief::step
