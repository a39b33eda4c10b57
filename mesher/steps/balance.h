// Balancing a lattice: one outer iteration of a constrained Newton method as per-vertex and per-cell gathers.
//
// Minimised: the sum over triangles of f(E), E = mean-ratio distortion (1 = equilateral, scale-free), under
// W_k = W for each honeycomb cell, the constraint being elastic (a bounded force, so that cells that cannot
// be filled give up and the others stay exact). Each vertex has its own 2 x 2 Hessian H of f; with J the
// derivative of the weights, a step is H^-1 (J^T lambda - grad f), lambda from
// (J H^-1 J^T + elasticity) lambda = W - W_k + J H^-1 grad f, a Poisson-like system on the lattice of cells,
// solved by Chebyshev sweeps over fixed bounds (no global sums).
#pragma once

#include <cmath>

#include "mesher/steps/lattice.h"
#include "mesher/steps/untangle.h"

namespace hexrelief::step {

// Constants of the method; none depends on the image.
inline constexpr float kEvenness = 0.02f;          // weight of E itself beside (E / threshold)^12
inline constexpr float kElasticity = 1e-4f;        // of a cell at its target weight
inline constexpr float kElasticityGrowth = 300;    // and for each unit of relative deviation
inline constexpr float kBorderElasticity = 0.05f;  // of the partial cells along the border
inline constexpr float kShapeReach =
    0.3f;                              // longest step for shape, in square roots of twice a triangle's area
inline constexpr float kReach = 0.5f;  // longest step of all
inline constexpr float kLeastShare = 0.3f;  // a step may not take more of a triangle's area ...
inline constexpr float kThin =
    0.12f;  // ... unless area / sum of squared sides stays above this (0.289 = equilateral)
inline constexpr float kLeastBalanceArea2_px = 1e-4f;
inline constexpr int kShrinkRounds =
    6;  // halvings of steps that would thin a triangle; the later half stop them

// Class of a vertex: 0 = centre of a honeycomb cell, 1 and 2 = rim vertices, each between three cells.
HEXRELIEF_HD int honeycomb_class(int column, int row) {
    const int d = (axial_q(column, row) - row) % 3;
    return d < 0 ? d + 3 : d;
}

// Mass flow through a directed segment: `flux` integrates the row primitive P dy (Green), mass and moment are
// the integrals of density and of density x t along it, t from 0 to 1.
struct EdgeMass {
    double flux;
    float mass, moment;
};

struct BalanceView {
    Lattice lattice;
    float extent_x, extent_y;  // of the image, px of the level
    bool pinned;               // the lattice's border lies on the image's
    int slots;                 // vertices of one class in a row, at most
    int stride;                // of a padded row of cells: slots + 2; there are rows + 4 rows
    float threshold;           // E at which a triangle counts as too thin
    // of the level's density: primitive[row * (width + 1) + x] is a row's integral from 0 to x
    int width, height;
    const double* primitive;
    double unit;  // 1 / the weight of a cell at perfect balance
    float floor;  // mass of an empty px, in that unit
    float* x;     // positions, one a vertex
    float* y;
    EdgeMass* edges;                                         // 3 x slots x rows
    float *inverse_xx, *inverse_xy, *inverse_yy, *reach;     // H^-1 and sqrt(mean twice area), one a vertex
    float *step_x, *step_y;                                  // first the shape's step, then the whole one
    float *gradient_x, *gradient_y;                          // 3 a vertex: dW / d position of its three cells
    float *weight, *residual, *diagonal, *inverse, *across;  // one a padded cell; across: 6 planes
    float *multiplier, *next_multiplier, *direction;         // lambda, one a padded cell
    float *scale, *next_scale;                               // of the steps, one a vertex
};

HEXRELIEF_HD int rim_slot(const BalanceView& v, int column, int row) {
    return row * v.slots + column / 3;
}
HEXRELIEF_HD int cell_slot(const BalanceView& v, int column, int row) {
    return (row + 2) * v.stride + column / 3 + 1;
}
HEXRELIEF_HD int cell_plane(const BalanceView& v) {
    return (v.lattice.rows + 4) * v.stride;
}
// Neighbour k of a vertex: where, and whether it exists.
struct Neighbour {
    int column, row, index;
    bool exists;
};

HEXRELIEF_HD Neighbour neighbour_of(const BalanceView& v, int column, int row, int k) {
    const Offset o = neighbour_offset(row, k);
    const int c = column + o.column, r = row + o.row;
    return {c, r, r * v.lattice.columns + c, c >= 0 && c < v.lattice.columns && r >= 0 && r < v.lattice.rows};
}

HEXRELIEF_HD LatticeView lattice_view(const BalanceView& v) {
    return {v.lattice.columns, v.lattice.rows, v.x, v.y};
}
HEXRELIEF_HD bool is_full_cell(const Lattice& l, int column, int row) {
    return column > 0 && column + 1 < l.columns && row > 0 && row + 1 < l.rows;
}
// Cells whose weight is held: all, or where the border moves freely only those with six neighbours.
HEXRELIEF_HD bool is_held_cell(const BalanceView& v, int column, int row) {
    return v.pinned || is_full_cell(v.lattice, column, row);
}

// Exact for a density constant in each pixel.
HEXRELIEF_HD EdgeMass edge_mass(const BalanceView& v, int from, int to) {
    const double ax = v.x[from], ay = v.y[from];
    const double dx = v.x[to] - ax, dy = v.y[to] - ay;
    int x = clamp_to(static_cast<int>(ax), 0, v.width - 1),
        y = clamp_to(static_cast<int>(ay), 0, v.height - 1);
    if (dx < 0 && ax == x && x > 0) --x;
    if (dy < 0 && ay == y && y > 0) --y;
    const int sx = dx < 0 ? -1 : 1, sy = dy < 0 ? -1 : 1;
    const double per_x = dx != 0 ? sx / dx : 0, per_y = dy != 0 ? sy / dy : 0;
    double next_x = dx > 0 ? (x + 1 - ax) * per_x : dx < 0 ? (ax - x) * per_x : 2;
    double next_y = dy > 0 ? (y + 1 - ay) * per_y : dy < 0 ? (ay - y) * per_y : 2;
    double flux = 0, mass = 0, moment = 0;
    const double* at = v.primitive + static_cast<std::size_t>(y) * (v.width + 1) + x;
    const int row_step = sy * (v.width + 1);
    for (double t = 0;;) {
        const double until = max_of(t, min_of(min_of(next_x, next_y), 1.0));
        const double density = at[1] - at[0], length = until - t, middle = (until + t) * 0.5;
        const double part = density * length;
        mass += part;
        moment += part * middle;
        flux += at[0] * length + (ax + middle * dx - x) * part;
        if (until >= 1) break;
        t = until;
        if (next_x <= next_y) {
            x += sx;
            at += sx;
            next_x += per_x;
            if (x < 0 || x >= v.width) break;
        } else {
            y += sy;
            at += row_step;
            next_y += per_y;
            if (y < 0 || y >= v.height) break;
        }
    }
    return {flux * dy * v.unit, static_cast<float>(mass * v.unit), static_cast<float>(moment * v.unit)};
}

// The three rim edges of a vertex of class 1, in directions 0, 2 and 4.
HEXRELIEF_HD void measure_rim_edges(const BalanceView& v, int column, int row) {
    for (int j = 0; j < 3; ++j) {
        const Neighbour to = neighbour_of(v, column, row, 2 * j);
        v.edges[3 * rim_slot(v, column, row) + j] =
            to.exists ? edge_mass(v, row * v.lattice.columns + column, to.index) : EdgeMass{0, 0, 0};
    }
}

struct ShapeSums {
    float gx = 0, gy = 0, hxx = 0, hxy = 0, hyy = 0;  // gradient and Hessian of the sum of f
    float area2 = 0;
};

// Adds the triangle (p, a, b), counter-clockwise, as a function of p.
HEXRELIEF_HD void add_triangle(float inverse_threshold, float px, float py, float ax, float ay, float bx,
                               float by, ShapeSums& sums) {
    const float c = 0.28867513f;  // 1 / (2 sqrt 3)
    const float ux = ax - px, uy = ay - py, vx = bx - px, vy = by - py, wx = bx - ax, wy = by - ay;
    const float area2 = max_of(ux * vy - uy * vx, kLeastBalanceArea2_px);
    const float inverse = 1.0f / area2;
    const float distortion = c * ((ux * ux + uy * uy) + (vx * vx + vy * vy) + (wx * wx + wy * wy)) * inverse;
    const float u = min_of(distortion * inverse_threshold, 4.0f);
    const float u2 = u * u, u4 = u2 * u2, u10 = u4 * u4 * u2;
    const float first = kEvenness + 12.0f * u10 * u * inverse_threshold;
    const float second = 132.0f * u10 * inverse_threshold * inverse_threshold;
    const float ex = (distortion * wy - 2.0f * c * (ux + vx)) * inverse;
    const float ey = (-distortion * wx - 2.0f * c * (uy + vy)) * inverse;
    const float k = first * inverse;
    sums.gx += first * ex;
    sums.gy += first * ey;
    sums.hxx += k * (4.0f * c + 2.0f * ex * wy) + second * ex * ex;
    sums.hxy += k * (ey * wy - ex * wx) + second * ex * ey;
    sums.hyy += k * (4.0f * c - 2.0f * ey * wx) + second * ey * ey;
    sums.area2 += area2;
}

// Writes H^-1 (given), the reach, and the shape's step from the sums over `triangles` triangles.
HEXRELIEF_HD void write_shape(const BalanceView& v, int i, const ShapeSums& s, float triangles, float xx,
                              float xy, float yy) {
    const float dx = -(xx * s.gx + xy * s.gy), dy = -(xy * s.gx + yy * s.gy);
    const float mean_area2 = s.area2 / triangles;
    const float longest2 = kShapeReach * kShapeReach * mean_area2;
    const float shrunk = sqrtf(longest2 / max_of(dx * dx + dy * dy, longest2));
    v.inverse_xx[i] = xx;
    v.inverse_xy[i] = xy;
    v.inverse_yy[i] = yy;
    v.reach[i] = sqrtf(mean_area2);
    v.step_x[i] = dx * shrunk;
    v.step_y[i] = dy * shrunk;
}

// Indices of a vertex's six neighbours relative to it.
struct VertexRing {
    int at[6];
};

HEXRELIEF_HD VertexRing vertex_ring(int columns, int row) {
    VertexRing ring;
    for (int k = 0; k < 6; ++k) {
        const Offset o = neighbour_offset(row, k);
        ring.at[k] = o.row * columns + o.column;
    }
    return ring;
}

HEXRELIEF_HD float least_determinant(const ShapeSums& s) {
    return max_of(s.hxx * s.hyy - s.hxy * s.hxy, 1e-6f * s.hxx * s.hyy);
}

// For a vertex with six neighbours; free of branches, so that rows of them run in vector registers.
HEXRELIEF_HD void shape_inner(const BalanceView& v, int i, float inverse_threshold, const VertexRing& ring) {
    const float x = v.x[i], y = v.y[i];
    float rx[6], ry[6];
#pragma GCC unroll 6
    for (int k = 0; k < 6; ++k) {
        rx[k] = v.x[i + ring.at[k]];
        ry[k] = v.y[i + ring.at[k]];
    }
    ShapeSums s;
    add_triangle(inverse_threshold, x, y, rx[0], ry[0], rx[1], ry[1], s);
    add_triangle(inverse_threshold, x, y, rx[1], ry[1], rx[2], ry[2], s);
    add_triangle(inverse_threshold, x, y, rx[2], ry[2], rx[3], ry[3], s);
    add_triangle(inverse_threshold, x, y, rx[3], ry[3], rx[4], ry[4], s);
    add_triangle(inverse_threshold, x, y, rx[4], ry[4], rx[5], ry[5], s);
    add_triangle(inverse_threshold, x, y, rx[5], ry[5], rx[0], ry[0], s);
    const float inverse = 1.0f / least_determinant(s);
    write_shape(v, i, s, 6.0f, s.hyy * inverse, -s.hxy * inverse, s.hxx * inverse);
}

// For a vertex of the lattice's border.
HEXRELIEF_HD void shape_border(const BalanceView& v, int column, int row, float inverse_threshold) {
    const LatticeView m = lattice_view(v);
    const int i = row * m.columns + column;
    ShapeSums s;
    float triangles = 0;
    for (int k = 0; k < 6; ++k) {
        const int a = neighbour(m, column, row, k), b = neighbour(m, column, row, (k + 1) % 6);
        if (a < 0 || b < 0) continue;
        add_triangle(inverse_threshold, v.x[i], v.y[i], v.x[a], v.y[a], v.x[b], v.y[b], s);
        triangles += 1.0f;
    }
    const bool hold_x = v.pinned && (column == 0 || column == m.columns - 1);
    const bool hold_y = v.pinned && (row == 0 || row == m.rows - 1);
    if (hold_x || hold_y) {
        write_shape(v, i, s, triangles, hold_x ? 0.0f : 1.0f / s.hxx, 0.0f, hold_y ? 0.0f : 1.0f / s.hyy);
    } else {
        const float inverse = 1.0f / least_determinant(s);
        write_shape(v, i, s, triangles, s.hyy * inverse, -s.hxy * inverse, s.hxx * inverse);
    }
}

// Direction from a rim vertex to its cell `j`, 0 <= j < 3.
HEXRELIEF_HD int cell_direction(int honeycomb_class, int j) {
    return 2 * j + (honeycomb_class == 1 ? 1 : 0);
}

// dW of the vertex's three cells: an edge that moves by d(t) sweeps the integral of density x d(t) x its
// normal.
HEXRELIEF_HD void rim_gradient(const BalanceView& v, int column, int row, int of_class) {
    const int i = row * v.lattice.columns + column;
    float ex[3], ey[3];  // mass x normal of the edge in direction 2 j (class 1) or 2 j + 1 (class 2)
    for (int j = 0; j < 3; ++j) {
        const int k = 2 * j + (of_class == 2 ? 1 : 0);
        const Neighbour to = neighbour_of(v, column, row, k);
        ex[j] = ey[j] = 0;
        if (!to.exists) continue;
        float mass = v.floor * 0.5f;
        if (of_class == 1) {
            const EdgeMass& e = v.edges[3 * rim_slot(v, column, row) + j];
            mass += e.mass - e.moment;
        } else {
            mass += v.edges[3 * rim_slot(v, to.column, to.row) + (k + 3) % 6 / 2].moment;
        }
        ex[j] = (v.y[to.index] - v.y[i]) * mass;
        ey[j] = -(v.x[to.index] - v.x[i]) * mass;
    }
    for (int j = 0; j < 3; ++j) {
        const int k = cell_direction(of_class, j);
        const Neighbour cell = neighbour_of(v, column, row, k);
        const bool held = cell.exists && is_held_cell(v, cell.column, cell.row);
        const int leaving = (k + 5) % 6 / 2,
                  arriving = (k + 1) % 6 / 2;  // the cell's rim arrives and leaves here
        v.gradient_x[3 * i + j] = held ? ex[leaving] - ex[arriving] : 0.0f;
        v.gradient_y[3 * i + j] = held ? ey[leaving] - ey[arriving] : 0.0f;
    }
}

// Which of a rim vertex's three gradients belongs to the cell that it sees in direction k.
HEXRELIEF_HD int gradient_slot(int k) {
    return k / 2;
}

// The cell's row of the system: weight, residual without the target, diagonal, and `across` towards the six
// cells around it (cell k lies beyond rim edge k, k + 1).
HEXRELIEF_HD void cell_equation(const BalanceView& v, int column, int row) {
    const LatticeView m = lattice_view(v);
    const int i = row * m.columns + column, slot = cell_slot(v, column, row), plane = cell_plane(v);
    double flux = 0;
    float area2 = 0, moved = 0, diagonal = 0, across[6] = {0, 0, 0, 0, 0, 0};
    for (int k = 0; k < 6; ++k) {
        const Neighbour na = neighbour_of(v, column, row, k), nb = neighbour_of(v, column, row, (k + 1) % 6);
        const int a = na.index;
        if (na.exists &&
            nb.exists) {  // rim edge a -> b, direction k + 2 from a; a is of class 1 where k is even
            const EdgeMass& e = k % 2 == 0 ? v.edges[3 * rim_slot(v, na.column, na.row) + (k + 2) % 6 / 2]
                                           : v.edges[3 * rim_slot(v, nb.column, nb.row) + (k + 5) % 6 / 2];
            flux += k % 2 == 0 ? e.flux : -e.flux;
            area2 += twice_area(m, i, a, nb.index);
        } else if (column == m.columns - 1 &&
                   na.exists) {  // along the image's right border, where P is not 0
            flux += edge_mass(v, a, i).flux;
        } else if (column == m.columns - 1 && nb.exists) {
            flux += edge_mass(v, i, nb.index).flux;
        }
        if (!na.exists) continue;
        const int back = (k + 3) % 6;  // direction from a to this cell; its others lie two and four further
        const float* const gx = v.gradient_x + 3 * a;
        const float* const gy = v.gradient_y + 3 * a;
        const float x = gx[gradient_slot(back)], y = gy[gradient_slot(back)];
        const float hx = v.inverse_xx[a] * x + v.inverse_xy[a] * y,
                    hy = v.inverse_xy[a] * x + v.inverse_yy[a] * y;
        const int before = gradient_slot((back + 2) % 6), after = gradient_slot((back + 4) % 6);
        moved += x * v.step_x[a] + y * v.step_y[a];
        diagonal += x * hx + y * hy;
        across[(k + 5) % 6] += gx[before] * hx + gy[before] * hy;
        across[k] += gx[after] * hx + gy[after] * hy;
    }
    v.weight[slot] = static_cast<float>(flux) + v.floor * 0.5f * area2;
    v.residual[slot] = -moved;
    v.diagonal[slot] = diagonal;
    for (int k = 0; k < 6; ++k) v.across[k * plane + slot] = across[k];
}

// Sixths of a whole cell that the cell's triangles make up.
HEXRELIEF_HD float cell_share(const BalanceView& v, int column, int row) {
    const LatticeView m = lattice_view(v);
    float share = 0;
    for (int k = 0; k < 6; ++k)
        if (neighbour(m, column, row, k) >= 0 && neighbour(m, column, row, (k + 1) % 6) >= 0)
            share += 1.0f / 6.0f;
    return share;
}

// Completes the row with the target weight and takes the first sweep from lambda = 0. The preconditioner is
// the sum of the row's magnitudes, so that all eigenvalues lie in (0, 1].
HEXRELIEF_HD void close_equation(const BalanceView& v, int column, int row, float target, float gain) {
    const int slot = cell_slot(v, column, row), plane = cell_plane(v);
    const bool full = is_full_cell(v.lattice, column, row);
    const float missing = target * (full ? 1.0f : cell_share(v, column, row)) - v.weight[slot];
    const float deviation = missing < 0 ? -missing : missing;
    const float diagonal =
        v.diagonal[slot] + (full ? kElasticity * (1.0f + kElasticityGrowth * deviation) : kBorderElasticity);
    float sum = diagonal;
    for (int k = 0; k < 6; ++k) {
        const float c = v.across[k * plane + slot];
        sum += c < 0 ? -c : c;
    }
    const float residual = missing + v.residual[slot];
    v.residual[slot] = residual;
    v.diagonal[slot] = diagonal;
    v.inverse[slot] = 1.0f / sum;
    v.direction[slot] = gain * (residual / sum);
    v.multiplier[slot] = v.direction[slot];
}

// Index distances to the six cells around a cell of a row.
struct CellRing {
    int at[6];
};

HEXRELIEF_HD CellRing cell_ring(const BalanceView& v, int row) {
    const int odd = row & 1, first = honeycomb_class(0, row) == 0 ? 0 : honeycomb_class(1, row) == 0 ? 1 : 2;
    const int right = (first + 1 + odd) / 3, left = (first - 2 + odd + 3) / 3 - 1;
    return {
        {v.stride + right, 2 * v.stride, v.stride + left, left - v.stride, -2 * v.stride, right - v.stride}};
}

// One Chebyshev sweep: direction = keep x direction + gain x preconditioned residual.
HEXRELIEF_HD void sweep_cell(const BalanceView& v, int slot, int plane, const CellRing& ring, float keep,
                             float gain) {
    const float* const l = v.multiplier + slot;
    const float* const c = v.across + slot;
    const float r = v.residual[slot] - v.diagonal[slot] * l[0] - c[0] * l[ring.at[0]] -
                    c[plane] * l[ring.at[1]] - c[2 * plane] * l[ring.at[2]] - c[3 * plane] * l[ring.at[3]] -
                    c[4 * plane] * l[ring.at[4]] - c[5 * plane] * l[ring.at[5]];
    const float d = keep * v.direction[slot] + gain * (r * v.inverse[slot]);
    v.direction[slot] = d;
    v.next_multiplier[slot] = l[0] + d;
}

}  // namespace hexrelief::step
