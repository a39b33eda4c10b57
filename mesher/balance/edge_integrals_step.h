// Balancing a lattice: one outer iteration of a constrained Newton method, computed for each vertex and each
// cell from its neighbours. This header holds the weights W_k of the honeycomb cells and their derivatives,
// as integrals along the cells' boundary edges (Green's theorem).
//
// The method minimises the sum over all triangles of f(E) subject to W_k = W for each honeycomb cell (paper,
// section 2.2, Eq. 1 and 2). E is the mean-ratio distortion of a triangle (1 = equilateral, independent of
// its size), f a steep penalty on small angles (triangle_distortion_step.h). The constraint is elastic: its
// force is bounded, so that cells that cannot be filled give up and the others stay exact. Each vertex has
// its own 2 x 2 Hessian H of f. If J is the derivative of the weights, a step is H^-1 (J^T lambda - grad f),
// with (J H^-1 J^T + elasticity) lambda = W - W_k + J H^-1 grad f. This Poisson-like system on the lattice of
// cells is solved by a few Chebyshev sweeps with fixed eigenvalue bounds, which need no global sums and start
// from the lambda of the preceding iteration.
#pragma once

#include <cstddef>
#include <cstdint>

#include "mesher/common/lattice_step.h"
#include "mesher/som/untangle_step.h"

namespace hexrelief::step {

// Constants of the method; none depends on the image.
inline constexpr float kEvenness = 0.03f;       // weight of E itself relative to the penalty
inline constexpr float kElasticity = 5e-4f;     // elasticity of a cell at its target weight
inline constexpr float kElasticityGrowth = 60;  // its relative growth per unit of deviation from the target
inline constexpr float kBorderElasticity = 0.05f;  // elasticity of the partial cells along the border
// Longest steps, in square roots of twice a triangle's area: kShapeReach for the shape's step,
// kReach for the whole.
inline constexpr float kShapeReach = 0.4f, kReach = 0.25f;
// A step must leave a triangle at least kLeastRemainingShare of its area, unless twice its area over the sum
// of its squared sides stays above kThinStep (equilateral: 0.289).
inline constexpr float kLeastRemainingShare = 0.3f, kThinStep = 0.12f;
inline constexpr float kLeastBalanceArea2_px = 1e-4f;  // smaller triangles are treated as this large
// Rounds in which steps that would spoil a triangle are shrunk: halved in the first half of the rounds,
// then set to 0.
inline constexpr int kShrinkRounds = 6;

// Returns the class of a vertex: 0 = centre of a honeycomb cell; 1 and 2 = boundary vertex,
// which three cells share.
HEXRELIEF_HD int honeycomb_class(int column, int row) {
    const int d = (axial_q(column, row) - row) % 3;
    return d < 0 ? d + 3 : d;
}

// Integrals along a directed edge. flux: of P dy, with P the density's primitive along rows
// (Green's theorem); mass: of the density; moment: of the density x t, with t from 0 at the edge's
// start to 1 at its end.
struct EdgeMass {
    double flux;
    float mass, moment;
};

// The arrays and constants of a level's balancing. Its pointers are not owned.
struct BalanceView {
    Lattice lattice;
    float extent_x, extent_y;  // size of the area, px of the level
    bool pinned;               // true: the lattice's border lies on the area's or on the outline
    Outline outline;           // if bent, its curves hold the first and last row
    int slots;                 // largest number of vertices of one class in a row
    int stride;                // slots in a padded row of cells: slots + 2; there are rows + 4 rows
    // Distortion E above which a triangle counts as too thin: start value and bounds; sine^2 of
    // the smallest angle wanted.
    float threshold, least_threshold, most_threshold, thin_sine2;
    // The level's density, width x height; primitive[row * (width + 1) + x] is a row's integral from 0 to x.
    int width, height;
    const double* primitive;
    double unit;  // weight per unit of mass, such that a cell's weight is 1 at perfect balance
    float floor;  // weight of an empty pixel
    float* x;     // positions, one per vertex
    float* y;
    EdgeMass* edges;     // 3 x slots x rows: edge j of a class 1 vertex, in direction 2 j
    double* right_flux;  // one per row: flux along the area's right border
    // flux along the columns - 1 edges of the first row, left to right, then of the last row, right to left
    double* end_flux;
    // H^-1 and sqrt(mean of twice the area), one per vertex
    float *inverse_xx, *inverse_xy, *inverse_yy, *reach;
    float *step_x, *step_y;               // first the shape's step, then the whole step
    float *gradient_x, *gradient_y;       // three per vertex: dW / d position of its three cells
    float *multiplier, *next_multiplier;  // lambda, one per padded cell
    float *scale, *next_scale;            // factors of the steps, one per vertex
    const std::uint8_t* held;             // one per vertex, nonzero: it stays; null: all move
};

// Slot of a boundary vertex among those of its class.
HEXRELIEF_HD int boundary_slot(const BalanceView& v, int column, int row) {
    return row * v.slots + column / 3;
}
// Slot of a cell in the padded arrays, by its centre.
HEXRELIEF_HD int cell_slot(const BalanceView& v, int column, int row) {
    return (row + 2) * v.stride + column / 3 + 1;
}
// Number of slots in a padded array of cells.
HEXRELIEF_HD int cell_plane(const BalanceView& v) {
    return (v.lattice.rows + 4) * v.stride;
}
// Neighbour k of a vertex: its position in the lattice, its index, and whether it exists.
struct Neighbour {
    int column, row, index;
    bool exists;
};

HEXRELIEF_HD Neighbour neighbour_of(const BalanceView& v, int column, int row, int k) {
    const Offset o = neighbour_offset(row, k);
    const int c = column + o.column, r = row + o.row;
    return {c, r, r * v.lattice.columns + c, c >= 0 && c < v.lattice.columns && r >= 0 && r < v.lattice.rows};
}

// The indices of a vertex's six neighbours, relative to its own.
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
// True if the vertex has six neighbours.
HEXRELIEF_HD bool is_full_cell(const Lattice& l, int column, int row) {
    return column > 0 && column + 1 < l.columns && row > 0 && row + 1 < l.rows;
}
// True if the cell's weight is held: for all cells if the border is pinned, else for
// those with six neighbours.
HEXRELIEF_HD bool is_held_cell(const BalanceView& v, int column, int row) {
    return v.pinned || is_full_cell(v.lattice, column, row);
}

// A directed edge between two vertices. The terms that are large and cancel between the edges of a cell are
// added in double precision; all others in single precision, which is far faster on a GPU.
struct Edge {
    float x, y, dx, dy;
    double rise;  // dy in double precision
};
// Sums along an edge.
struct EdgeSums {
    double columns;  // the primitive at the pixels' left sides
    // the rest of the primitive within the pixels; the density; the density x t
    float within, mass, moment;
};

HEXRELIEF_HD EdgeSums operator+(const EdgeSums& a, const EdgeSums& b) {
    return {a.columns + b.columns, a.within + b.within, a.mass + b.mass, a.moment + b.moment};
}

HEXRELIEF_HD Edge edge_between(float x, float y, float to_x, float to_y) {
    return {x, y, to_x - x, to_y - y, static_cast<double>(to_y) - static_cast<double>(y)};
}

// An edge as a walk along the axis in which it is longer: x if `sideways`, else y.
struct EdgeWalk {
    float x, dx;
    float along, across, rise_across, per_along, per_across;
    int sideways, first, sign, ahead;  // ahead: 1 if the walk leaves a pixel at its higher side, else 0
};

// Returns the walk along an edge. Reciprocals of zero lengths are set to 0.
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

// Returns the number of pixels that an edge visits along that axis.
HEXRELIEF_HD int edge_pixels(const Edge& e) {
    const bool sideways = e.dx * e.dx >= e.dy * e.dy;
    const float a = sideways ? e.x : e.y, d = sideways ? e.dx : e.dy;
    return abs_of(static_cast<int>(a + d) - static_cast<int>(a)) + 1;
}

// The part of an edge in pixel k of its walk, for t from t0 to t1. At `crossing` the edge passes from one
// pixel to the next in the other axis; (column, row) and (other_column, other_row) are these two pixels. If
// the edge stays in one of them, the segment in the other has length 0.
struct PixelCut {
    float t0, crossing, t1;
    int column, other_column, row, other_row;
};

// Returns the part of an edge in pixel k, 0 <= k < count, of its walk.
HEXRELIEF_HD PixelCut pixel_cut(const BalanceView& v, const EdgeWalk& e, int k, int count) {
    const int pixel = e.first + e.sign * k;
    const float enters = min_of((static_cast<float>(pixel + 1 - e.ahead) - e.along) * e.per_along, 1.0f),
                leaves = min_of((static_cast<float>(pixel + e.ahead) - e.along) * e.per_along, 1.0f);
    const float t0 = k == 0 ? 0.0f : enters, t1 = k == count - 1 ? 1.0f : leaves;
    const int from = static_cast<int>(e.across + t0 * e.rise_across),
              to = static_cast<int>(e.across + t1 * e.rise_across);
    const float border = clamp_to((static_cast<float>(max_of(from, to)) - e.across) * e.per_across, t0, t1);
    // segments beyond the last pixel have length 0
    const int last_column = v.width - 1, last_row = v.height - 1;
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
// the pixel's left and right side.
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

// Adds pixel k of `count`, in which the edge crosses at most one pixel border of the other axis. Exact for a
// density that is constant within each pixel.
HEXRELIEF_HD void add_pixel(const BalanceView& v, const EdgeWalk& e, int k, int count, EdgeSums& sums) {
    const PixelCut cut = pixel_cut(v, e, k, count);
    const double *const here = v.primitive + primitive_index(v, cut.column, cut.row),
                        *const there = v.primitive + primitive_index(v, cut.other_column, cut.other_row);
    add_segment(e, {cut.column, here[0], here[1], cut.t0, cut.crossing}, sums);
    add_segment(e, {cut.other_column, there[0], there[1], cut.crossing, cut.t1}, sums);
}

// An edge is summed in interleaved parts: part p of n takes pixels p, p + n, p + 2 n and so on. The threads
// of a device or the lanes of a SIMD batch take a part each; a long edge has as many parts as a warp has
// threads. The parts are independent, so reads and arithmetic overlap.
inline constexpr int kEdgeParts = 4, kLongEdgeParts = 32, kLongEdge_px = 16;

// Returns the sums over the pixels of one part.
HEXRELIEF_HD EdgeSums edge_part(const BalanceView& v, const Edge& e, int part, int parts) {
    const EdgeWalk walk = edge_walk(e);
    const int count = edge_pixels(e);
    EdgeSums sums = {0, 0, 0, 0};
    for (int k = part; k < count; k += parts) add_pixel(v, walk, k, count, sums);
    return sums;
}

// Returns an edge's integrals, in the units of the view, from the sums along it.
HEXRELIEF_HD EdgeMass mass_of(const BalanceView& v, const Edge& e, const EdgeSums& s) {
    return {(s.columns + static_cast<double>(s.within)) * e.rise * v.unit,
            static_cast<float>(static_cast<double>(s.mass) * v.unit),
            static_cast<float>(static_cast<double>(s.moment) * v.unit)};
}

// Adds the four parts of a short edge in pairs.
HEXRELIEF_HD EdgeSums sum_of_parts(const EdgeSums& a, const EdgeSums& b, const EdgeSums& c,
                                   const EdgeSums& d) {
    return (a + b) + (c + d);
}

// Adds the parts of a long edge in pairs, pairs of pairs and so on; overwrites `sums`.
HEXRELIEF_HD EdgeSums sum_of_long_parts(EdgeSums* sums) {
    for (int n = kLongEdgeParts / 2; n > 0; n /= 2)
        for (int k = 0, pair = 0; k < n; ++k, pair += 2) sums[k] = sums[pair] + sums[pair + 1];
    return sums[0];
}

// Returns the integrals along the edge between two vertices.
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

// Measures the edge of the lattice's right border from a row to the next, needed if the border is pinned. (On
// the left border the primitive is 0.)
HEXRELIEF_HD void measure_right_edge(const BalanceView& v, int row) {
    const int from = (row + 1) * v.lattice.columns - 1;
    v.right_flux[row] = edge_mass(v, from, from + v.lattice.columns).flux;
}

// The vertices of an edge of the first or last row.
struct EdgeEnds {
    int from, to;
};

// Returns edge k of view.end_flux: the edges of the first row, then those of the last. They are needed if
// these rows are bent.
HEXRELIEF_HD EdgeEnds end_edge(const Lattice& lattice, int k) {
    const int edges = lattice.columns - 1, last = (lattice.rows - 1) * lattice.columns;
    return k < edges ? EdgeEnds{k, k + 1} : EdgeEnds{last + k - edges + 1, last + k - edges};
}

HEXRELIEF_HD void measure_end_edge(const BalanceView& v, int k) {
    const EdgeEnds e = end_edge(v.lattice, k);
    v.end_flux[k] = edge_mass(v, e.from, e.to).flux;
}

// Returns the direction from a boundary vertex to its cell `j`, 0 <= j < 3.
HEXRELIEF_HD int cell_direction(int honeycomb_class, int j) {
    return 2 * j + (honeycomb_class == 1 ? 1 : 0);
}

// Writes the derivatives of the weights of the boundary vertex's three cells with respect to its position: an
// edge whose points move by d(t) sweeps the integral of density x d(t) x its normal.
HEXRELIEF_HD void boundary_gradient(const BalanceView& v, int column, int row, int of_class) {
    const int i = row * v.lattice.columns + column;
    // (ex, ey) is mass x normal of the edge in direction 2 j (class 1) or 2 j + 1 (class 2). A cell's
    // gradient is the difference of the two edges that enclose it. The loop is not unrolled, to keep one copy
    // of the code on a device.
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

// Returns the index, among a boundary vertex's three gradients, of the cell in direction k from it.
HEXRELIEF_HD int gradient_slot(int k) {
    return k / 2;
}

}  // namespace hexrelief::step
