// A balancing iteration as phases with waits between them, by a group of threads: one block, a cluster of
// blocks with a share of the rows each, or the whole grid. The first two keep the level in shared memory, and
// blocks beside them measure its edges. Included by balance.cu only.
#pragma once

#include "cuda/balance/balance.h"
#include "cuda/balance/edge_integrals.cuh"
#include "cuda/balance/placement.cuh"
#include "cuda/balance/thread_groups.cuh"
#include "mesher/balance/cell_equations_step.h"
#include "mesher/balance/cell_mass_step.h"
#include "mesher/balance/convergence_step.h"
#include "mesher/balance/line_search_step.h"
#include "mesher/balance/triangle_distortion_step.h"
#include "mesher/som/untangle_step.h"

namespace hexrelief::cuda {

// views: four copies of one view, with the two multipliers (1) and the two scales (2) swapped or not; in
// shared memory, for some thirty pointers are more than a thread's registers hold.
template <typename ThreadPool, bool kResident>
class Balancer {
  public:
    __device__ Balancer(const BalanceJob& job, const step::BalanceView* views, std::uint8_t* marks,
                        std::uint8_t* grown, ThreadPool& group)
        : job_(job),
          views_(views),
          marks_(marks),
          grown_(grown),
          group_(group),
          lattice_(job.view.lattice),
          vertices_(group.first_row, group.last_row - group.first_row, lattice_.columns),
          cells_(group.first_row, group.last_row - group.first_row, job.view.slots),
          place_(vertices_.at(group.thread)),
          cell_(cell_place(group.thread)),
          threshold_(job.view.threshold) {}

    __device__ void work() {
        Equations<kResident> equations(job_);
        if (threadIdx.x == 0) group_.scratch->next_piece = 0;
#pragma unroll 1
        for (bool over = false;; over = true) {  // one copy of unfold()
            unfold();
            if (over) break;
            if constexpr (ThreadPool::kWindowed) publish();
#pragma unroll 1
            for (int t = 0;; ++t) {
                const bool lifts = t == job_.limits.most || (t > 0 && !go_on(t));  // the last turn
                if (lifts && !(job_.limits.finest && step::is_bent(job_.view.outline))) break;
                if (!lifts) {
                    measure(t);
                    group_.wait();
                    gradients();
                    group_.wait();
                    solve(equations, t);
                }
                propose(lifts);
                group_.wait();
                shrink();
                take(lifts);
                if constexpr (ThreadPool::kWindowed)
                    if (!lifts) publish();
                group_.wait();
                if (lifts) break;
            }
            if constexpr (ThreadPool::kWindowed) group_.dismiss_helpers();
        }
    }

  private:
    // What the iteration before tells; false where the level is done.
    __device__ bool go_on(int t) {
        const step::BalanceSums sums = group_.sums_of(t - 1);
        const float deviation = step::mean_weight(sums.deviation, job_.full_cells);
        const bool in_shape = !step::has_thin(job_.view, sums.thin, step::kThinShare);
        if (step::is_done(job_.limits, t, deviation, target_, in_shape, deviation_before_)) return false;
        threshold_ = step::next_threshold(job_.view, sums.thin, step::is_late(job_.limits, t), threshold_);
        target_ = step::mean_weight(sums.weight, job_.full_cells);
        return true;
    }

    __device__ const step::BalanceView& view() const {
        return views_[state_];
    }
    __device__ int index(const Place& p) const {
        return p.row * lattice_.columns + p.column;
    }

    template <typename Visit>
    __device__ __forceinline__ void each_vertex(const Visit& visit) {
        Place p = place_;
#pragma unroll 1
        for (int item = group_.thread; item < vertices_.count;) {  // one copy of what visit does
            visit(p);
            item += group_.threads;
            if (item < vertices_.count) p = vertices_.at(item);
        }
    }

    __device__ CellPlace cell_place(int item) const {
        Place p = cells_.at(item);
        p.column = column_of_class(p.column, p.row, 0);
        if (item >= cells_.count || p.column >= lattice_.columns ||
            !step::is_held_cell(job_.view, p.column, p.row))
            return {p, item, 0, {}, false};
        return {p, item, step::cell_slot(job_.view, p.column, p.row), step::cell_ring(job_.view, p.row),
                true};
    }
    template <typename Visit>
    __device__ __forceinline__ void each_cell(const Visit& visit) {
        if constexpr (kResident) {
            if (cell_.held) visit(cell_);
        } else {
#pragma unroll 1
            for (int item = group_.thread; item < cells_.count; item += group_.threads) {
                const CellPlace cell = cell_place(item);
                if (cell.held) visit(cell);
            }
        }
    }

    // Silhouette edges, the right border, and the vertices' shapes. In windows the helpers measure the edges
    // meanwhile; else warps take pieces of both as they come.
    __device__ void measure(int t) {
        const step::BalanceView& v = view();
        const step::ShapeLimits limits = step::shape_limits(v, threshold_, step::is_late(job_.limits, t));
        thin_ = 0;
        if constexpr (ThreadPool::kWindowed) {
            each_vertex([&](const Place& p) { measure_shape(v, p, limits); });
            group_.helpers.wait();
            fetch_edges(v);
        } else {
            const EdgePieces<false> edges(v);
            const int lane = threadIdx.x % 32, blocks = gridDim.x, block = blockIdx.x;
            const int edge_pieces = (edges.count - block + blocks - 1) / blocks,
                      all = edge_pieces + ((vertices_.count + 31) / 32 - block + blocks - 1) / blocks;
            int& next = group_.scratch->next_piece;
#pragma unroll 1
            for (int piece = next_of(next); piece < all; piece = next_of(next)) {
                const int vertex = ((piece - edge_pieces) * blocks + block) * 32 + lane;
                if (piece < edge_pieces)
                    edges.measure(v, piece * blocks + block, lane);
                else if (vertex < vertices_.count)
                    measure_shape(v, vertices_.at(vertex), limits);
            }
        }
    }
    // Those of the window's rows, as the helpers left them.
    __device__ void fetch_edges(const step::BalanceView& v) {
        const int begin = max(group_.first_row - 1, 0), end = min(group_.last_row + 1, lattice_.rows);
        const int row_length = 3 * v.slots;
        for (int i = begin * row_length + threadIdx.x; i < end * row_length; i += blockDim.x)
            v.edges[i] = job_.view.edges[i];
        if (!v.pinned) return;
        for (int row = begin + threadIdx.x; row < min(end, lattice_.rows - 1); row += blockDim.x)
            v.right_flux[row] = job_.view.right_flux[row];
    }
    // Gives the vertices' positions to the helpers, who begin.
    __device__ void publish() {
        const step::BalanceView& v = view();
        each_vertex([&](const Place& p) {
            const int i = index(p);
            job_.view.x[i] = v.x[i];
            job_.view.y[i] = v.y[i];
        });
        group_.helpers.ask();
    }
    __device__ __forceinline__ void measure_shape(const step::BalanceView& v, const Place& p,
                                                  const step::ShapeLimits& limits) {
        const int i = index(p);
        thin_ += step::shape_of(v, p.column, p.row, limits);
        for (float* const array : {v.inverse_xx, v.inverse_xy, v.inverse_yy, v.step_x, v.step_y})
            group_.share(array + i, p.row, lattice_.columns);
    }

    __device__ void gradients() {
        const step::BalanceView& v = view();
        if (!ThreadPool::kWindowed && threadIdx.x == 0) group_.scratch->next_piece = 0;
#pragma unroll 1
        for (int item = group_.thread; item < 2 * cells_.count; item += group_.threads) {
            const int of_class = item < cells_.count ? 1 : 2;
            Place p = cells_.at(of_class == 1 ? item : item - cells_.count);
            p.column = column_of_class(p.column, p.row, of_class);
            if (p.column >= lattice_.columns) continue;
            step::silhouette_gradient(v, p.column, p.row, of_class);
            const int i = 3 * index(p);
            for (int j = 0; j < 3; ++j) {
                group_.share(v.gradient_x + i + j, p.row, 3 * lattice_.columns);
                group_.share(v.gradient_y + i + j, p.row, 3 * lattice_.columns);
            }
        }
    }

    __device__ void solve(Equations<kResident>& equations, int t) {
        const step::BalanceView& v = view();
        step::BalanceSums sums{0, 0, thin_};
        each_cell([&](const CellPlace& cell) {
            const auto [column, row] = cell.place;
            step::CellEquation& e = equations.at(cell.item);
            e = step::cell_equation<false>(v, column, row);
            if (step::is_full_cell(lattice_, column, row)) step::add_cell(e.weight, target_, sums);
        });
        group_.add(sums, t);
        if (t == 0) {
            group_.wait();
            target_ = step::mean_weight(group_.sums_of(0).weight, job_.full_cells);
        }
        each_cell([&](const CellPlace& cell) {
            step::close_equation(v, cell.place.column, cell.place.row, target_, equations.at(cell.item));
            equations.direction_at(cell.item) = 0;
        });
        float *from = v.multiplier, *to = v.next_multiplier;
#pragma unroll 1
        for (int sweep = 0; sweep < job_.sweeps; ++sweep) {
            const SweepGain gain = job_.gains[sweep];
            each_cell([&](const CellPlace& cell) {
                to[cell.slot] = step::swept(equations.at(cell.item), from + cell.slot, cell.ring, gain.keep,
                                            gain.gain, equations.direction_at(cell.item));
                group_.share_far(&to[cell.slot], cell.place.row, v.stride);
            });
            float* const swap = from;
            from = to;
            to = swap;
            group_.wait();
        }
        state_ ^= job_.sweeps & 1;
    }

    __device__ void propose(bool lifts) {
        const step::BalanceView& v = view();
        each_vertex([&](const Place& p) {
            if (lifts)
                step::propose_lift(v, p.column, p.row);
            else
                step::propose_step(v, p.column, p.row);
            const int i = index(p);
            for (float* const array : {v.step_x, v.step_y, v.scale})
                group_.share(array + i, p.row, lattice_.columns);
        });
    }

    __device__ void shrink() {
#pragma unroll 1
        for (int round = 0; round < step::kShrinkRounds; ++round) {
            const step::BalanceView& v = view();
            const float factor = step::shrink_factor(round);
            int any = 0;
            each_vertex([&](const Place& p) {
                const int i = index(p);
                const int spoils = step::spoils_any(v, p.column, p.row);
                v.next_scale[i] = v.scale[i] * (spoils ? factor : 1.0f);
                group_.share(v.next_scale + i, p.row, lattice_.columns);
                any |= spoils;
            });
            state_ ^= 2;
            if (!group_.any(any)) return;
        }
    }

    __device__ void take(bool lifts) {
        const step::BalanceView& v = view();
        each_vertex([&](const Place& p) {
            const int i = index(p);
            step::take_step(v, i, !lifts);
            group_.share(v.x + i, p.row, lattice_.columns);
            group_.share(v.y + i, p.row, lattice_.columns);
        });
    }

    // As hexrelief::untangle.
    __device__ void unfold() {
        const step::BalanceView& v = view();
        const step::LatticeView m = step::lattice_view(v);
        const int around = ThreadPool::kWindowed ? 1 : 0;  // rows of others
        for (int row = max(group_.first_row - around, 0); row < min(group_.last_row + around, m.rows); ++row)
            for (int column = group_.thread; column < m.columns; column += group_.threads)
                marks_[row * m.columns + column] = 0;
        group_.wait();
        for (int sweep = 0; sweep < step::kMostUntangleSweeps; ++sweep) {
            int any = 0;
            each_vertex([&](const Place& p) {
                if (!step::folded(m, p.column, p.row)) return;
                marks_[index(p)] = 1;
                group_.share(&marks_[index(p)], p.row, m.columns);
                any = 1;
            });
            if (!group_.any(any)) return;
            if (sweep % step::kUntangleGrowth == step::kUntangleGrowth - 1) {
                each_vertex([&](const Place& p) {
                    std::uint8_t marked = marks_[index(p)];
                    for (int k = 0; k < 6; ++k) {
                        const int n = step::neighbour(m, p.column, p.row, k);
                        if (n >= 0) marked |= marks_[n];
                    }
                    grown_[index(p)] = marked;
                    group_.share(&grown_[index(p)], p.row, m.columns);
                });
                std::uint8_t* const before = marks_;
                marks_ = grown_;
                grown_ = before;
                group_.wait();
            }
            each_vertex([&](const Place& p) {
                const int i = index(p);
                float x = m.x[i], y = m.y[i];
                if (marks_[i])
                    step::smoothed_position(m, {v.pinned, v.outline}, sweep, p.column, p.row, x, y);
                v.step_x[i] = x;
                v.step_y[i] = y;
            });
            group_.wait();
            each_vertex([&](const Place& p) {
                const int i = index(p);
                v.x[i] = v.step_x[i];
                v.y[i] = v.step_y[i];
                group_.share(v.x + i, p.row, m.columns);
                group_.share(v.y + i, p.row, m.columns);
            });
            group_.wait();
        }
    }

    const BalanceJob& job_;
    const step::BalanceView* const views_;
    std::uint8_t *marks_, *grown_;
    ThreadPool& group_;
    const step::Lattice lattice_;
    const RowItems<ThreadPool::kWindowed> vertices_, cells_;
    const Place place_;
    const CellPlace cell_;
    int state_ = 0, thin_ = 0;
    float threshold_, target_ = 1, deviation_before_ = 1e30f;
};

}  // namespace hexrelief::cuda
