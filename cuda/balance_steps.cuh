// A balancing iteration as phases with waits between them, by a team of threads: one block, a cluster of
// blocks with a share of the rows each, or the whole grid. Included by balance.cu only.
#pragma once

#include "cuda/balance.h"
#include "mesher/steps/balance_cells.h"
#include "mesher/steps/balance_mass.h"
#include "mesher/steps/balance_move.h"
#include "mesher/steps/balance_shape.h"
#include "mesher/steps/untangle.h"

namespace hexrelief::cuda {

// A lattice vertex; inner: it has six neighbours.
struct Place {
    int column, row;
    bool inner;
};

// The vertices of rows [first, last) in an order that keeps those of the lattice's border apart, so that
// warps do not take both ways.
struct VertexOrder {
    int columns, first, inner_count, padded, top, bottom, count;

    __device__ VertexOrder(const step::Lattice& lattice, int first_row, int last_row)
        : columns(lattice.columns) {
        first = max(first_row, 1);
        const int rows = max(0, min(last_row, lattice.rows - 1) - first);
        inner_count = rows * (columns - 2);
        padded = (inner_count + 31) / 32 * 32;
        top = first_row == 0 && last_row > 0 ? columns : 0;
        bottom = last_row == lattice.rows && last_row > first_row ? columns : 0;
        count = padded + top + bottom + 2 * rows;
    }
    // row -1 for what pads
    __device__ Place at(int item, int last_row) const {
        if (item < inner_count) {
            const int row = item / (columns - 2);
            return {1 + item - row * (columns - 2), first + row, true};
        }
        int k = item - padded;
        if (k < 0 || item >= count) return {0, -1, false};
        if (k < top) return {k, 0, false};
        k -= top;
        if (k < bottom) return {k, last_row, false};
        k -= bottom;
        return {k & 1 ? columns - 1 : 0, first + k / 2, false};
    }
};

__device__ __forceinline__ int first_of_class(int row, int of_class) {
    return step::honeycomb_class(0, row) == of_class ? 0 : step::honeycomb_class(1, row) == of_class ? 1 : 2;
}

// The cells of a thread: in registers where it has at most one, else in memory.
template <bool kResident>
struct Cells;

template <>
struct Cells<true> {
    step::CellEquation equation;
    float direction;
    __device__ explicit Cells(const BalanceJob&) : equation{}, direction(0) {}
    __device__ step::CellEquation& at(int) { return equation; }
    __device__ float& direction_at(int) { return direction; }
};

template <>
struct Cells<false> {
    step::CellEquation* equations;
    float* directions;
    __device__ explicit Cells(const BalanceJob& job) : equations(job.equations), directions(job.directions) {}
    __device__ step::CellEquation& at(int item) { return equations[item]; }
    __device__ float& direction_at(int item) { return directions[item]; }
};

// views: four copies of one view, with the two multipliers (1) and the two scales (2) swapped or not; in
// shared memory, for some thirty pointers are more than a thread's registers hold.
template <typename Team, bool kResident>
class Balancer {
  public:
    __device__ Balancer(const BalanceJob& job, const step::BalanceView* views, std::uint8_t* marks,
                        std::uint8_t* grown, Team& team)
        : job_(job),
          views_(views),
          marks_(marks),
          grown_(grown),
          team_(team),
          lattice_(job.view.lattice),
          order_(job.view.lattice, team.first_row, team.last_row),
          slots_(job.view.slots) {
        once_ = order_.count <= team.threads;
        place_ = order_.at(team.thread, lattice_.rows - 1);
    }

    __device__ void work() {
        unfold();
        Cells<kResident> cells(job_);
        for (int t = 0; t < job_.iterations; ++t) {
            measure();
            team_.wait();
            gradients();
            team_.wait();
            solve(cells, t);
            propose();
            team_.wait();
            shrink();
            take();
            team_.wait();
        }
        unfold();
    }

  private:
    __device__ const step::BalanceView& view() const { return views_[state_]; }
    __device__ int index(const Place& p) const { return p.row * lattice_.columns + p.column; }

    template <typename Visit>
    __device__ __forceinline__ void each_vertex(const Visit& visit) {
        if (once_) {
            if (place_.row >= 0) visit(place_);
            return;
        }
        for (int item = team_.thread; item < order_.count; item += team_.threads) {
            const Place p = order_.at(item, lattice_.rows - 1);
            if (p.row >= 0) visit(p);
        }
    }
    // visit(item, column, row) for each vertex of a class
    template <typename Visit>
    __device__ __forceinline__ void each_of_class(int of_class, int first_item, const Visit& visit) {
        const int items = (team_.last_row - team_.first_row) * slots_;
        for (int item = first_item; item < items; item += team_.threads) {
            const int local = item / slots_, row = team_.first_row + local;
            const int column = first_of_class(row, of_class) + 3 * (item - local * slots_);
            if (column < lattice_.columns) visit(item, column, row);
        }
    }

    // Rim edges, the right border, and the vertices' shapes, on different warps as far as there are enough.
    __device__ void measure() {
        const step::BalanceView& v = view();
        const int rows = team_.last_row - team_.first_row, edges = 3 * slots_ * rows;
        const int right = (edges + 31) / 32 * 32, right_end = v.pinned ? right + rows : right;
        const int vertices = (right_end + 31) / 32 * 32;
        const float inverse_threshold = 1.0f / v.threshold;
        for (int item = team_.thread; item < vertices + order_.count; item += team_.threads) {
            if (item >= vertices) {
                const Place p = order_.at(item - vertices, lattice_.rows - 1);
                if (p.row < 0) continue;
                const int i = index(p);
                if (p.inner)
                    step::shape_inner(v, i, inverse_threshold, step::vertex_ring(lattice_.columns, p.row));
                else
                    step::shape_border(v, p.column, p.row, inverse_threshold);
                for (float* const array : {v.inverse_xx, v.inverse_xy, v.inverse_yy, v.step_x, v.step_y})
                    team_.share(array + i, p.row, lattice_.columns);
            } else if (item < edges) {
                const int local = item / (3 * slots_), within = item - local * 3 * slots_;
                const int row = team_.first_row + local, column = first_of_class(row, 1) + within / 3 * 3;
                if (column >= lattice_.columns) continue;
                step::measure_rim_edge(v, column, row, within % 3);
                team_.share(&v.edges[3 * step::rim_slot(v, column, row) + within % 3], row, 3 * slots_);
            } else if (item >= right && item < right_end) {
                const int row = team_.first_row + item - right;
                if (row + 1 >= lattice_.rows) continue;
                step::measure_right_edge(v, row);
                team_.share(&v.right_flux[row], row, 1);
            }
        }
    }

    __device__ void gradients() {
        const step::BalanceView& v = view();
        const int items = (team_.last_row - team_.first_row) * slots_;
        for (int item = team_.thread; item < 2 * items; item += team_.threads) {
            const int of_class = item < items ? 1 : 2, k = item < items ? item : item - items;
            const int local = k / slots_, row = team_.first_row + local;
            const int column = first_of_class(row, of_class) + 3 * (k - local * slots_);
            if (column >= lattice_.columns) continue;
            step::rim_gradient(v, column, row, of_class);
            const int i = 3 * (row * lattice_.columns + column);
            for (int j = 0; j < 3; ++j) {
                team_.share(v.gradient_x + i + j, row, 3 * lattice_.columns);
                team_.share(v.gradient_y + i + j, row, 3 * lattice_.columns);
            }
        }
    }

    __device__ void solve(Cells<kResident>& cells, int t) {
        std::int64_t sum = 0;
        {
            const step::BalanceView& v = view();
            each_of_class(0, team_.thread, [&](int item, int column, int row) {
                if (!step::is_held_cell(v, column, row)) return;
                const step::CellEquation e = step::cell_equation(v, column, row);
                if (step::is_full_cell(lattice_, column, row)) sum += step::whole_weight(e.weight);
                cells.at(item) = e;
            });
        }
        const float target = step::target_weight(team_.sum(sum, t), job_.full_cells);
        {
            const step::BalanceView& v = view();
            each_of_class(0, team_.thread, [&](int item, int column, int row) {
                if (!step::is_held_cell(v, column, row)) return;
                step::close_equation(v, column, row, target, cells.at(item));
                cells.direction_at(item) = 0;
            });
        }
        for (int sweep = 0; sweep < job_.sweeps; ++sweep) {
            const step::BalanceView& v = view();
            const SweepGain gain = job_.gains[sweep];
            each_of_class(0, team_.thread, [&](int item, int column, int row) {
                if (!step::is_held_cell(v, column, row)) return;
                const int slot = step::cell_slot(v, column, row);
                v.next_multiplier[slot] =
                    step::swept(cells.at(item), v.multiplier + slot, step::cell_ring(v, row), gain.keep,
                                gain.gain, cells.direction_at(item));
                team_.share_far(&v.next_multiplier[slot], row, v.stride);
            });
            state_ ^= 1;
            team_.wait();
        }
    }

    __device__ void propose() {
        const step::BalanceView& v = view();
        each_vertex([&](const Place& p) {
            step::propose_step(v, p.column, p.row);
            const int i = index(p);
            for (float* const array : {v.step_x, v.step_y, v.scale})
                team_.share(array + i, p.row, lattice_.columns);
        });
    }

    __device__ void shrink() {
        for (int round = 0; round < step::kShrinkRounds; ++round) {
            const step::BalanceView& v = view();
            const float factor = step::shrink_factor(round);
            int any = 0;
            each_vertex([&](const Place& p) {
                const int i = index(p);
                const int spoils = p.inner
                                       ? step::spoils_inner(v, i, step::vertex_ring(lattice_.columns, p.row))
                                       : step::spoils_border(v, p.column, p.row);
                v.next_scale[i] = v.scale[i] * (spoils ? factor : 1.0f);
                team_.share(v.next_scale + i, p.row, lattice_.columns);
                any |= spoils;
            });
            state_ ^= 2;
            if (!team_.any(any)) return;
        }
    }

    __device__ void take() {
        const step::BalanceView& v = view();
        each_vertex([&](const Place& p) {
            const int i = index(p);
            step::take_step(v, i);
            team_.share(v.x + i, p.row, lattice_.columns);
            team_.share(v.y + i, p.row, lattice_.columns);
        });
    }

    // As hexrelief::untangle.
    __device__ void unfold() {
        const step::BalanceView& v = view();
        const step::LatticeView m = step::lattice_view(v);
        const int around = Team::kWindowed ? 1 : 0;  // rows of others
        for (int row = max(team_.first_row - around, 0); row < min(team_.last_row + around, m.rows); ++row)
            for (int column = team_.thread; column < m.columns; column += team_.threads)
                marks_[row * m.columns + column] = 0;
        team_.wait();
        for (int sweep = 0; sweep < step::kMostUntangleSweeps; ++sweep) {
            int any = 0;
            each_vertex([&](const Place& p) {
                if (!step::folded(m, p.column, p.row)) return;
                marks_[index(p)] = 1;
                team_.share(&marks_[index(p)], p.row, m.columns);
                any = 1;
            });
            if (!team_.any(any)) return;
            if (sweep % step::kUntangleGrowth == step::kUntangleGrowth - 1) {
                each_vertex([&](const Place& p) {
                    std::uint8_t marked = marks_[index(p)];
                    for (int k = 0; k < 6; ++k) {
                        const int n = step::neighbour(m, p.column, p.row, k);
                        if (n >= 0) marked |= marks_[n];
                    }
                    grown_[index(p)] = marked;
                    team_.share(&grown_[index(p)], p.row, m.columns);
                });
                std::uint8_t* const before = marks_;
                marks_ = grown_;
                grown_ = before;
                team_.wait();
            }
            each_vertex([&](const Place& p) {
                const int i = index(p);
                float x = m.x[i], y = m.y[i];
                if (marks_[i]) step::smoothed_position(m, p.column, p.row, v.pinned, x, y);
                v.step_x[i] = x;
                v.step_y[i] = y;
            });
            team_.wait();
            each_vertex([&](const Place& p) {
                const int i = index(p);
                v.x[i] = v.step_x[i];
                v.y[i] = v.step_y[i];
                team_.share(v.x + i, p.row, m.columns);
                team_.share(v.y + i, p.row, m.columns);
            });
            team_.wait();
        }
    }

    const BalanceJob& job_;
    const step::BalanceView* const views_;
    std::uint8_t *marks_, *grown_;
    Team& team_;
    const step::Lattice lattice_;
    const VertexOrder order_;
    const int slots_;
    bool once_;
    Place place_;
    int state_ = 0;
};

}  // namespace hexrelief::cuda
