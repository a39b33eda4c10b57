// Balancing a lattice, one outer iteration of a constrained Newton method, computed for each vertex and each
// cell from its neighbours. This header: the weights W_k of the honeycomb cells and their derivatives, as
// integrals along the cells' boundary edges (Green's theorem).
//
// Minimised is the sum over all triangles of f(E) under W_k = W for each honeycomb cell (paper, section 2.2,
// Eq. 1 and 2). E is the mean-ratio distortion of a triangle (1 = equilateral, independent of its size), f a
// steep penalty on small angles (triangle_distortion_step.h). The constraint is elastic: its force is
// bounded, so that cells that cannot be filled give up and the others stay exact. Each vertex has its own 2 x
// 2 Hessian H of f. With J the derivative of the weights, a step is H^-1 (J^T lambda - grad f), where (J H^-1
// J^T + elasticity) lambda = W - W_k + J H^-1 grad f. This Poisson-like system on the lattice of cells is
// solved by a few Chebyshev sweeps for fixed eigenvalue bounds, which need no global sums and start from the
// lambda of the iteration before.
#pragma once

#include <cstddef>
#include <cstdint>

#include "mesher/common/lattice_step.h"
#include "mesher/som/untangle_step.h"

namespace hexrelief::step {

// Constants of the method; none depends on the image.
inline constexpr float kEvenness = 0.03f;          // weight of E itself beside the penalty
inline constexpr float kElasticity = 5e-4f;        // of a cell at its target weight
inline constexpr float kElasticityGrowth = 60;     // relative growth for each unit of deviation from it
inline constexpr float kBorderElasticity = 0.05f;  // of the partial cells along the border
// Longest steps, in square roots of twice a triangle's area: for shape alone, and of all.
inline constexpr float kShapeReach = 0.4f, kReach = 0.25f;
// A step must leave a triangle at least this share of its area, unless twice its area over the sum of its
// squared sides stays above kThinStep (equilateral: 0.289).
inline constexpr float kLeastRemainingShare = 0.3f, kThinStep = 0.12f;
inline constexpr float kLeastBalanceArea2_px = 1e-4f;  // smaller triangles count as this large
// Rounds in which steps that would spoil a triangle are shrunk: halved in the first half, then set to 0.
inline constexpr int kShrinkRounds = 6;

// Class of a vertex: 0 = centre of a honeycomb cell; 1 and 2 = boundary vertex, which three cells share.
HEXRELIEF_HD int honeycomb_class(int column, int row) {
    const int d = (axial_q(column, row) - row) % 3;
    return d < 0 ? d + 3 : d;
}

// Integrals along a directed edge: flux of the row primitive, P dy (Green's theorem); mass and moment of
// density and of density x t, t from 0 at its start to 1.
struct EdgeMass {
    double flux;
    float mass, moment;
};

struct BalanceView {
    Lattice lattice;
    float extent_x, extent_y;  // of the image, px of the level
    bool pinned;               // the lattice's border lies on the area's ...
    Outline outline;           // ... or on these curves
    int slots;                 // vertices of one class in a row, at most
    int stride;                // of a padded row of cells: slots + 2; there are rows + 4 rows
    // E at which a triangle counts as too thin: first value and bounds; sine^2 of the smallest angle wanted
    float threshold, least_threshold, most_threshold, thin_sine2;
    // of the level's density: primitive[row * (width + 1) + x] is a row's integral from 0 to x
    int width, height;
    const double* primitive;
    double unit;  // 1 / the weight of a cell at perfect balance
    float floor;  // mass of an empty px, in that unit
    float* x;     // positions, one a vertex
    float* y;
    EdgeMass* edges;     // 3 x slots x rows: edge j of a class 1 vertex, in direction 2 j
    double* right_flux;  // one a row: of the area's right border
    double* end_flux;    // columns - 1 of the first row, to the right, then those of the last, to the left
    float *inverse_xx, *inverse_xy, *inverse_yy, *reach;  // H^-1 and sqrt(mean twice area), one a vertex
    float *step_x, *step_y;                               // first the shape's step, then the whole one
    float *gradient_x, *gradient_y;                       // 3 a vertex: dW / d position of its three cells
    float *multiplier, *next_multiplier;                  // lambda, one a padded cell
    float *scale, *next_scale;                            // of the steps, one a vertex
    const std::uint8_t* held;                             // one a vertex, not 0: it stays; null: all move
};

HEXRELIEF_HD int boundary_slot(const BalanceView& v, int column, int row) {
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

// A directed edge between two vertices, and sums along it. Terms that are large and cancel between the edges
// of a cell are added in double precision, all others in single precision, which is far faster on a GPU.
struct Edge {
    float x, y, dx, dy;
    double rise;  // dy, exactly
};
struct EdgeSums {
    double columns;              // of the primitive at the pixels' left sides
    float within, mass, moment;  // of the rest of the primitive; of the density; of density x t
};

HEXRELIEF_HD EdgeSums operator+(const EdgeSums& a, const EdgeSums& b) {
    return {a.columns + b.columns, a.within + b.within, a.mass + b.mass, a.moment + b.moment};
}

HEXRELIEF_HD Edge edge_between(float x, float y, float to_x, float to_y) {
    return {x, y, to_x - x, to_y - y, static_cast<double>(to_y) - static_cast<double>(y)};
}

// An edge as a walk along the axis in which it is longer; sideways: this is x.
struct EdgeWalk {
    float x, dx;
    float along, across, rise_across, per_along, per_across;
    int sideways, first, sign, ahead;  // ahead: from a pixel's index to its far side
};

HEXRELIEF_HD EdgeWalk edge_walk(const Edge& e) {
    const bool sideways = e.dx * e.dx >= e.dy * e.dy;
    const float a = sideways ? e.x : e.y, d = sideways ? e.dx : e.dy;
    const float b = sideways ? e.y : e.x, c = sideways ? e.dy : e.dx;
    return {e.x,
            e.dx,
            a,
            b,
            c,
            d != 0 ? 1 / d : 0.0f,
            c != 0 ? 1 / c : 0.0f,
            static_cast<int>(sideways),
            static_cast<int>(a),
            d < 0 ? -1 : 1,
            d < 0 ? 0 : 1};
}

// Pixels of an edge along that axis.
HEXRELIEF_HD int edge_pixels(const Edge& e) {
    const bool sideways = e.dx * e.dx >= e.dy * e.dy;
    const float a = sideways ? e.x : e.y, d = sideways ? e.dx : e.dy;
    return abs_of(static_cast<int>(a + d) - static_cast<int>(a)) + 1;
}

// The part of an edge in pixel k of its walk, t from t0 to t1. At `crossing` the edge goes from one pixel to
// the next in the other axis; column, row and other_column, other_row are these two pixels. Where the edge
// stays in one of them, the segment in the other has length 0.
struct PixelCut {
    float t0, crossing, t1;
    int column, other_column, row, other_row;
};

HEXRELIEF_HD PixelCut pixel_cut(const BalanceView& v, const EdgeWalk& e, int k, int count) {
    const int pixel = e.first + e.sign * k;
    const float enters = min_of((static_cast<float>(pixel + 1 - e.ahead) - e.along) * e.per_along, 1.0f),
                leaves = min_of((static_cast<float>(pixel + e.ahead) - e.along) * e.per_along, 1.0f);
    const float t0 = k == 0 ? 0.0f : enters, t1 = k == count - 1 ? 1.0f : leaves;
    const int from = static_cast<int>(e.across + t0 * e.rise_across),
              to = static_cast<int>(e.across + t1 * e.rise_across);
    const float border = clamp_to((static_cast<float>(max_of(from, to)) - e.across) * e.per_across, t0, t1);
    const int last_column = v.width - 1, last_row = v.height - 1;  // beyond lie parts of no length
    return {t0,
            from == to ? t1 : border,
            t1,
            clamp_to(e.sideways ? pixel : from, 0, last_column),
            clamp_to(e.sideways ? pixel : to, 0, last_column),
            clamp_to(e.sideways ? from : pixel, 0, last_row),
            clamp_to(e.sideways ? to : pixel, 0, last_row)};
}

HEXRELIEF_HD std::size_t primitive_index(const BalanceView& v, int column, int row) {
    return static_cast<std::size_t>(row) * (v.width + 1) + column;
}

// The segment of an edge with t in [t0, t1], within one pixel of this column; left, right: the primitive at
// the pixel's two sides.
struct PixelSegment {
    int column;
    double left, right;
    float t0, t1;
};

HEXRELIEF_HD void add_segment(const EdgeWalk& e, const PixelSegment& s, EdgeSums& sums) {
    const float middle = (s.t1 + s.t0) * 0.5f;
    const float part = static_cast<float>(s.right - s.left) * (s.t1 - s.t0);
    sums.mass += part;
    sums.moment += part * middle;
    sums.within += ((e.x - static_cast<float>(s.column)) + middle * e.dx) * part;
    sums.columns += s.left * (static_cast<double>(s.t1) - static_cast<double>(s.t0));
}

// Adds pixel k of `count`, in which the edge crosses at most one border between pixels of the other axis.
// Exact for a density that is constant in each pixel.
HEXRELIEF_HD void add_pixel(const BalanceView& v, const EdgeWalk& e, int k, int count, EdgeSums& sums) {
    const PixelCut cut = pixel_cut(v, e, k, count);
    const double *const here = v.primitive + primitive_index(v, cut.column, cut.row),
                        *const there = v.primitive + primitive_index(v, cut.other_column, cut.other_row);
    add_segment(e, {cut.column, here[0], here[1], cut.t0, cut.crossing}, sums);
    add_segment(e, {cut.other_column, there[0], there[1], cut.crossing, cut.t1}, sums);
}

// An edge is summed in interleaved parts: part p of n takes pixels p, p + n, p + 2 n and so on. The threads
// of a device or the lanes of a vector register take a part each; a long edge has as many parts as a warp has
// threads. No part waits for another, so reads and arithmetic overlap.
inline constexpr int kEdgeParts = 4, kLongEdgeParts = 32, kLongEdge_px = 16;

HEXRELIEF_HD EdgeSums edge_part(const BalanceView& v, const Edge& e, int part, int parts) {
    const EdgeWalk walk = edge_walk(e);
    const int count = edge_pixels(e);
    EdgeSums sums = {0, 0, 0, 0};
    for (int k = part; k < count; k += parts) add_pixel(v, walk, k, count, sums);
    return sums;
}

HEXRELIEF_HD EdgeMass mass_of(const BalanceView& v, const Edge& e, const EdgeSums& s) {
    return {(s.columns + static_cast<double>(s.within)) * e.rise * v.unit,
            static_cast<float>(static_cast<double>(s.mass) * v.unit),
            static_cast<float>(static_cast<double>(s.moment) * v.unit)};
}

// The sum of the four parts of a short edge, in pairs.
HEXRELIEF_HD EdgeSums sum_of_parts(const EdgeSums& a, const EdgeSums& b, const EdgeSums& c,
                                   const EdgeSums& d) {
    return (a + b) + (c + d);
}

// The sum of the parts of a long edge, in pairs, pairs of pairs and so on; overwrites `sums`.
HEXRELIEF_HD EdgeSums sum_of_long_parts(EdgeSums* sums) {
    for (int n = kLongEdgeParts / 2; n > 0; n /= 2)
        for (int k = 0, pair = 0; k < n; ++k, pair += 2) sums[k] = sums[pair] + sums[pair + 1];
    return sums[0];
}

HEXRELIEF_HD EdgeMass edge_mass(const BalanceView& v, int from, int to) {
    const Edge e = edge_between(v.x[from], v.y[from], v.x[to], v.y[to]);
    if (edge_pixels(e) <= kLongEdge_px)
        return mass_of(v, e,
                       sum_of_parts(edge_part(v, e, 0, kEdgeParts), edge_part(v, e, 1, kEdgeParts),
                                    edge_part(v, e, 2, kEdgeParts), edge_part(v, e, 3, kEdgeParts)));
    EdgeSums sums[kLongEdgeParts];
    for (int k = 0; k < kLongEdgeParts; ++k) sums[k] = edge_part(v, e, k, kLongEdgeParts);
    return mass_of(v, e, sum_of_long_parts(sums));
}

// The edge of the lattice's right border from a row to the next, needed where the border is pinned. (On the
// left border the primitive is 0.)
HEXRELIEF_HD void measure_right_edge(const BalanceView& v, int row) {
    const int from = (row + 1) * v.lattice.columns - 1;
    v.right_flux[row] = edge_mass(v, from, from + v.lattice.columns).flux;
}

// Vertices of edge k of v.end_flux: edges of the first row, then of the last. Needed where
// these rows are bent.
struct EdgeEnds {
    int from, to;
};

HEXRELIEF_HD EdgeEnds end_edge(const Lattice& lattice, int k) {
    const int edges = lattice.columns - 1, last = (lattice.rows - 1) * lattice.columns;
    return k < edges ? EdgeEnds{k, k + 1} : EdgeEnds{last + k - edges + 1, last + k - edges};
}

HEXRELIEF_HD void measure_end_edge(const BalanceView& v, int k) {
    const EdgeEnds e = end_edge(v.lattice, k);
    v.end_flux[k] = edge_mass(v, e.from, e.to).flux;
}

// Direction from a boundary vertex to its cell `j`, 0 <= j < 3.
HEXRELIEF_HD int cell_direction(int honeycomb_class, int j) {
    return 2 * j + (honeycomb_class == 1 ? 1 : 0);
}

// Derivatives of the weights of the boundary vertex's three cells by its position: an edge whose points move
// by d(t) sweeps the integral of density x d(t) x its normal.
HEXRELIEF_HD void boundary_gradient(const BalanceView& v, int column, int row, int of_class) {
    const int i = row * v.lattice.columns + column;
    // Mass x normal of the edges in directions 2 j (class 1) or 2 j + 1 (class 2). Between one edge
    // and the next lies cell j, or the one after it. The loop is not unrolled, to keep one copy of the
    // code on a device.
    float first_x = 0, first_y = 0, last_x = 0, last_y = 0;
    HEXRELIEF_ROLLED
    for (int j = 0; j <= 3; ++j) {
        float ex = j < 3 ? 0.0f : first_x, ey = j < 3 ? 0.0f : first_y;
        const int k = 2 * j + (of_class == 2 ? 1 : 0);
        const Neighbour to = neighbour_of(v, column, row, j < 3 ? k : 0);
        if (j < 3 && to.exists) {
            float mass = v.floor * 0.5f;
            if (of_class == 1) {
                const EdgeMass& e = v.edges[3 * boundary_slot(v, column, row) + j];
                mass += e.mass - e.moment;
            } else {
                mass += v.edges[3 * boundary_slot(v, to.column, to.row) + (k + 3) % 6 / 2].moment;
            }
            ex = (v.y[to.index] - v.y[i]) * mass;
            ey = -(v.x[to.index] - v.x[i]) * mass;
        }
        if (j == 0) {
            first_x = ex;
            first_y = ey;
        } else {
            const int at = of_class == 1 ? j - 1 : j % 3;
            const Neighbour cell = neighbour_of(v, column, row, cell_direction(of_class, at));
            const bool held = cell.exists && is_held_cell(v, cell.column, cell.row);
            v.gradient_x[3 * i + at] = held ? last_x - ex : 0.0f;
            v.gradient_y[3 * i + at] = held ? last_y - ey : 0.0f;
        }
        last_x = ex;
        last_y = ey;
    }
}

// Index of a boundary vertex's gradient for the cell in direction k from it.
HEXRELIEF_HD int gradient_slot(int k) {
    return k / 2;
}

}  // namespace hexrelief::step
