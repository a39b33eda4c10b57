// A balancing iteration as phases with waits between them, run by the threads of a communicator: one block, a
// cluster of blocks with a share of the rows each, or the whole grid. The first two keep the level in shared
// memory, and helper blocks measure its edges. Included only by balance.cu.
#pragma once

#include "cuda/balance/balance.h"
#include "cuda/balance/communicators.cuh"
#include "cuda/balance/edge_integrals.cuh"
#include "cuda/balance/work_items.cuh"
#include "mesher/balance/cell_equations_step.h"
#include "mesher/balance/convergence_step.h"
#include "mesher/balance/triangle_distortion_step.h"
#include "mesher/som/untangle_step.h"

namespace hexrelief::cuda {

// views: four copies of one view, in which the two arrays of multipliers (bit 0 of the index) and of scales
// (bit 1) are swapped or not. They are in shared memory, because some thirty pointers are too many for a
// thread's registers. kResident: each thread has at most one cell.
template <typename Communicator, bool kResident>
class Balancer {
  public:
    __device__ Balancer(const BalanceJob& job, const step::BalanceView* views, std::uint8_t* marks,
                        std::uint8_t* grown, Communicator& comm)
        : job_(job),
          views_(views),
          marks_(marks),
          grown_(grown),
          comm_(comm),
          lattice_(job.view.lattice),
          vertices_(comm.first_row, comm.last_row - comm.first_row, lattice_.columns),
          cells_(comm.first_row, comm.last_row - comm.first_row, job.view.slots),
          vertex_(vertices_.at(comm.thread)),
          cell_(cell_item(comm.thread)),
          threshold_(job.view.threshold) {}

    __device__ void work() {
        Equations<kResident> equations(job_);
        if (threadIdx.x == 0) comm_.scratch->next_batch = 0;
#pragma unroll 1
        for (bool over = false;; over = true) {  // a loop, to keep a single copy of untangle() in the code
            untangle();
            if (over) break;
            if constexpr (Communicator::kWindowed) publish();
#pragma unroll 1
            for (int t = 0;; ++t) {
                // the last pass
                const bool lifts = t == job_.limits.most || (t > 0 && !go_on(t));
                if (lifts && !(job_.limits.finest && step::is_bent(job_.view.outline))) break;
                if (!lifts) {
                    measure(t);
                    comm_.wait();
                    gradients();
                    comm_.wait();
                    solve(equations, t);
                }
                propose(lifts);
                comm_.wait();
                shrink();
                take(lifts);
                if constexpr (Communicator::kWindowed)
                    if (!lifts) publish();
                comm_.wait();
                if (lifts) break;
            }
            if constexpr (Communicator::kWindowed) comm_.dismiss_helpers();
        }
    }

  private:
    // Takes the target and the threshold from the preceding iteration; returns false if the level is done.
    __device__ bool go_on(int t) {
        const step::BalanceSums sums = comm_.sums_of(t - 1);
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
    // True if a vertex is held. It reads the job, whose pointer is a constant of the launch: this costs
    // nothing if it is null.
    __device__ bool is_held(int vertex) const {
        return job_.view.held && job_.view.held[vertex];
    }
    __device__ int index(const LatticeIndex& p) const {
        return p.row * lattice_.columns + p.column;
    }

    template <typename Visit>
    __device__ __forceinline__ void each_vertex(const Visit& visit) {
        LatticeIndex p = vertex_;
#pragma unroll 1
        for (int item = comm_.thread; item < vertices_.count;) {  // a single copy of visit() in the code
            visit(p);
            item += comm_.threads;
            if (item < vertices_.count) p = vertices_.at(item);
        }
    }

    __device__ CellItem cell_item(int item) const {
        LatticeIndex p = cells_.at(item);
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
            for (int item = comm_.thread; item < cells_.count; item += comm_.threads) {
                const CellItem cell = cell_item(item);
                if (cell.held) visit(cell);
            }
        }
    }

    // Measures the boundary edges, the right border, and the vertices' shapes. Helpers, if there are any,
    // measure the edges at the same time; otherwise warps take batches of edges, then of vertices.
    __device__ void measure(int t) {
        const step::BalanceView& v = view();
        const step::ShapeLimits limits = step::shape_limits(v, threshold_, step::is_late(job_.limits, t));
        thin_ = 0;
        if constexpr (Communicator::kWindowed) {
            each_vertex([&](const LatticeIndex& p) { measure_shape(v, p, limits); });
            comm_.helpers.wait();
            fetch_edges(v);
        } else {
            const EdgeBatches<false> edges(v);
            const int lane = threadIdx.x % 32, blocks = gridDim.x, block = blockIdx.x;
            const int edge_batches = (edges.count - block + blocks - 1) / blocks,
                      all = edge_batches + ((vertices_.count + 31) / 32 - block + blocks - 1) / blocks;
            int& next = comm_.scratch->next_batch;
#pragma unroll 1
            for (int batch = next_of(next); batch < all; batch = next_of(next)) {
                const int vertex = ((batch - edge_batches) * blocks + block) * 32 + lane;
                if (batch < edge_batches)
                    edges.measure(v, batch * blocks + block, lane);
                else if (vertex < vertices_.count)
                    measure_shape(v, vertices_.at(vertex), limits);
            }
        }
    }
    // Copies the edges of the window's rows from the memory to which the helpers wrote them.
    __device__ void fetch_edges(const step::BalanceView& v) {
        const int begin = max(comm_.first_row - 1, 0), end = min(comm_.last_row + 1, lattice_.rows);
        const int row_length = 3 * v.slots;
        for (int i = begin * row_length + threadIdx.x; i < end * row_length; i += blockDim.x)
            v.edges[i] = job_.view.edges[i];
        if (!v.pinned) return;
        for (int row = begin + threadIdx.x; row < min(end, lattice_.rows - 1); row += blockDim.x)
            v.right_flux[row] = job_.view.right_flux[row];
    }
    // Writes the vertices' positions to the memory from which the helpers read them, and starts the helpers.
    __device__ void publish() {
        const step::BalanceView& v = view();
        each_vertex([&](const LatticeIndex& p) {
            const int i = index(p);
            job_.view.x[i] = v.x[i];
            job_.view.y[i] = v.y[i];
        });
        comm_.helpers.request();
    }
    __device__ __forceinline__ void measure_shape(const step::BalanceView& v, const LatticeIndex& p,
                                                  const step::ShapeLimits& limits) {
        const int i = index(p);
        thin_ += step::shape_of(v, p.column, p.row, limits);
        if (is_held(i)) step::hold_vertex(v, i);
        for (float* const array : {v.inverse_xx, v.inverse_xy, v.inverse_yy, v.step_x, v.step_y})
            comm_.share(array + i, p.row, lattice_.columns);
    }

    __device__ void gradients() {
        const step::BalanceView& v = view();
        if (!Communicator::kWindowed && threadIdx.x == 0) comm_.scratch->next_batch = 0;
#pragma unroll 1
        for (int item = comm_.thread; item < 2 * cells_.count; item += comm_.threads) {
            const int of_class = item < cells_.count ? 1 : 2;
            LatticeIndex p = cells_.at(of_class == 1 ? item : item - cells_.count);
            p.column = column_of_class(p.column, p.row, of_class);
            if (p.column >= lattice_.columns) continue;
            step::boundary_gradient(v, p.column, p.row, of_class);
            const int i = 3 * index(p);
            for (int j = 0; j < 3; ++j) {
                comm_.share(v.gradient_x + i + j, p.row, 3 * lattice_.columns);
                comm_.share(v.gradient_y + i + j, p.row, 3 * lattice_.columns);
            }
        }
    }

    __device__ void solve(Equations<kResident>& equations, int t) {
        const step::BalanceView& v = view();
        step::BalanceSums sums{0, 0, thin_};
        each_cell([&](const CellItem& cell) {
            const auto [column, row] = cell.at;
            step::CellEquation& e = equations.at(cell.item);
            e = step::cell_equation<false>(v, column, row);
            if (step::is_full_cell(lattice_, column, row)) step::add_cell(e.weight, target_, sums);
        });
        comm_.add(sums, t);
        if (t == 0) {
            comm_.wait();
            target_ = step::mean_weight(comm_.sums_of(0).weight, job_.full_cells);
        }
        each_cell([&](const CellItem& cell) {
            step::close_equation(v, cell.at.column, cell.at.row, target_, equations.at(cell.item));
            equations.direction_at(cell.item) = 0;
        });
        float *from = v.multiplier, *to = v.next_multiplier;
#pragma unroll 1
        for (int sweep = 0; sweep < job_.sweeps; ++sweep) {
            const balance::SweepGain gain = job_.gains[sweep];
            each_cell([&](const CellItem& cell) {
                to[cell.slot] =
                    step::chebyshev_sweep(equations.at(cell.item), from + cell.slot, cell.ring, gain.keep,
                                          gain.gain, equations.direction_at(cell.item));
                comm_.share_far(&to[cell.slot], cell.at.row, v.stride);
            });
            float* const swap = from;
            from = to;
            to = swap;
            comm_.wait();
        }
        state_ ^= job_.sweeps & 1;
    }

    __device__ void propose(bool lifts) {
        const step::BalanceView& v = view();
        each_vertex([&](const LatticeIndex& p) {
            if (lifts)
                step::propose_lift(v, p.column, p.row);
            else
                step::propose_step(v, p.column, p.row);
            const int i = index(p);
            for (float* const array : {v.step_x, v.step_y, v.scale})
                comm_.share(array + i, p.row, lattice_.columns);
        });
    }

    __device__ void shrink() {
#pragma unroll 1
        for (int round = 0; round < step::kShrinkRounds; ++round) {
            const step::BalanceView& v = view();
            const float factor = step::shrink_factor(round);
            int any = 0;
            each_vertex([&](const LatticeIndex& p) {
                const int i = index(p);
                const int spoils = step::spoils_any(v, p.column, p.row);
                v.next_scale[i] = v.scale[i] * (spoils ? factor : 1.0f);
                comm_.share(v.next_scale + i, p.row, lattice_.columns);
                any |= spoils;
            });
            state_ ^= 2;
            if (!comm_.any(any)) return;
        }
    }

    __device__ void take(bool lifts) {
        const step::BalanceView& v = view();
        each_vertex([&](const LatticeIndex& p) {
            const int i = index(p);
            step::take_step(v, i, !lifts);
            comm_.share(v.x + i, p.row, lattice_.columns);
            comm_.share(v.y + i, p.row, lattice_.columns);
        });
    }

    // Does the same as som::untangle().
    __device__ void untangle() {
        const step::BalanceView& v = view();
        const step::LatticeView m = step::lattice_view(v);
        const int around = Communicator::kWindowed ? 1 : 0;  // halo rows
        for (int row = max(comm_.first_row - around, 0); row < min(comm_.last_row + around, m.rows); ++row)
            for (int column = comm_.thread; column < m.columns; column += comm_.threads)
                marks_[row * m.columns + column] = 0;
        comm_.wait();
        for (int sweep = 0; sweep < step::kMostUntangleSweeps; ++sweep) {
            int any = 0;
            each_vertex([&](const LatticeIndex& p) {
                if (!step::folded(m, p.column, p.row)) return;
                marks_[index(p)] = 1;
                comm_.share(&marks_[index(p)], p.row, m.columns);
                any = 1;
            });
            if (!comm_.any(any)) return;
            if (sweep % step::kUntangleGrowth == step::kUntangleGrowth - 1) {
                each_vertex([&](const LatticeIndex& p) {
                    std::uint8_t marked = marks_[index(p)];
                    for (int k = 0; k < 6; ++k) {
                        const int n = step::neighbour(m, p.column, p.row, k);
                        if (n >= 0) marked |= marks_[n];
                    }
                    grown_[index(p)] = marked;
                    comm_.share(&grown_[index(p)], p.row, m.columns);
                });
                std::uint8_t* const before = marks_;
                marks_ = grown_;
                grown_ = before;
                comm_.wait();
            }
            each_vertex([&](const LatticeIndex& p) {
                const int i = index(p);
                step::Position smoothed{m.x[i], m.y[i]};
                if (marks_[i] && !is_held(i))
                    smoothed = step::smoothed_position(m, {v.pinned, v.outline}, sweep, p.column, p.row);
                v.step_x[i] = smoothed.x;
                v.step_y[i] = smoothed.y;
            });
            comm_.wait();
            each_vertex([&](const LatticeIndex& p) {
                const int i = index(p);
                v.x[i] = v.step_x[i];
                v.y[i] = v.step_y[i];
                comm_.share(v.x + i, p.row, m.columns);
                comm_.share(v.y + i, p.row, m.columns);
            });
            comm_.wait();
        }
    }

    const BalanceJob& job_;
    const step::BalanceView* const views_;
    std::uint8_t *marks_, *grown_;
    Communicator& comm_;
    const step::Lattice lattice_;
    const RowItems<Communicator::kWindowed> vertices_, cells_;
    const LatticeIndex vertex_;
    const CellItem cell_;
    int state_ = 0, thin_ = 0;
    float threshold_, target_ = 1, deviation_before_ = 1e30f;
};

}  // namespace hexrelief::cuda
