// A balancing iteration as phases with waits between them, by a team of threads: one block, a cluster of
// blocks with a share of the rows each, or the whole grid. Included by balance.cu only.
#pragma once

#include "cuda/balance.h"
#include "cuda/balance_places.cuh"
#include "cuda/balance_teams.cuh"
#include "mesher/steps/balance_cells.h"
#include "mesher/steps/balance_mass.h"
#include "mesher/steps/balance_move.h"
#include "mesher/steps/balance_shape.h"
#include "mesher/steps/untangle.h"

namespace hexrelief::cuda {

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
          order_(job.view.lattice, team.first_row, team.last_row, 1),
          class_order_(job.view.lattice, team.first_row, team.last_row, 3),
          place_(order_.at(team.thread)),
          cell_(cell_place(team.thread)) {}

    __device__ void work() {
        Equations<kResident> equations(job_);
#pragma unroll 1
        for (bool over = false;; over = true) {  // one copy of unfold()
            unfold();
            if (over) break;
#pragma unroll 1
            for (int t = 0; t < job_.iterations; ++t) {
                measure();
                team_.wait();
                gradients();
                team_.wait();
                solve(equations, t);
                propose();
                team_.wait();
                shrink();
                take();
                team_.wait();
            }
        }
    }

  private:
    __device__ const step::BalanceView& view() const {
        return views_[state_];
    }
    __device__ int index(const Place& p) const {
        return p.row * lattice_.columns + p.column;
    }

    using Order = VertexOrder<Team::kWindowed>;

    template <typename Visit>
    __device__ __forceinline__ void each_vertex(const Visit& visit) {
        Place p = place_;
#pragma unroll 1
        for (int item = team_.thread;;) {  // one copy of what visit does: the kernel must fit the cache
            if (p.row >= 0) visit(p);
            item += team_.threads;
            if (item >= order_.count) return;
            p = order_.at(item);
        }
    }

    __device__ CellPlace cell_place(int item) const {
        const Place p = class_order_.at(item, 0);
        if (p.row < 0 || !step::is_held_cell(job_.view, p.column, p.row)) return {p, item, 0, {}, false};
        return {p, item, step::cell_slot(job_.view, p.column, p.row), step::cell_ring(job_.view, p.row),
                true};
    }
    template <typename Visit>
    __device__ __forceinline__ void each_cell(const Visit& visit) {
        if constexpr (kResident) {
            if (cell_.held) visit(cell_);
        } else {
#pragma unroll 1
            for (int item = team_.thread; item < class_order_.count; item += team_.threads) {
                const CellPlace cell = cell_place(item);
                if (cell.held) visit(cell);
            }
        }
    }

    // Rim edges, the right border, and the vertices' shapes, on different warps as far as there are enough.
    // An edge is the work of kEdgeParts threads, or the longest would keep all others waiting.
    __device__ void measure() {
        const step::BalanceView& v = view();
        const int rows = team_.last_row - team_.first_row;
        const int right = (3 * class_order_.count + 31) / 32 * 32;
        const int edges = step::kEdgeParts * (v.pinned ? right + (rows + 31) / 32 * 32 : right);
        const float inverse_threshold = 1.0f / v.threshold;
#pragma unroll 1
        for (int item = team_.thread; item < edges + order_.count; item += team_.threads) {
            if (item >= edges)
                measure_shape(v, order_.at(item - edges), inverse_threshold);
            else
                measure_edge(v, edge_place(v, item / step::kEdgeParts, right, rows));
        }
    }
    // An edge among measure()'s items: a rim edge, or one of the right border (j = 3).
    struct EdgePlace {
        int column, row, j, from, to;
        bool there;
    };
    __device__ __forceinline__ EdgePlace edge_place(const step::BalanceView& v, int item, int right,
                                                    int rows) const {
        const int rims = class_order_.count;
        if (item >= right) {
            const int row = team_.first_row + item - right, from = (row + 1) * lattice_.columns - 1;
            return {lattice_.columns - 1,
                    row,
                    3,
                    from,
                    from + lattice_.columns,
                    item < right + rows && row + 1 < lattice_.rows};
        }
        const int j = item < rims ? 0 : item < 2 * rims ? 1 : 2;
        const Place p = class_order_.at(item - j * rims, 1);
        if (j > 2 || item >= 3 * rims || p.row < 0) return {0, 0, 0, 0, 0, false};
        const step::Neighbour to = step::neighbour_of(v, p.column, p.row, 2 * j);
        return {p.column, p.row, j, index(p), to.exists ? to.index : -1, true};
    }
    __device__ __forceinline__ void measure_edge(const step::BalanceView& v, const EdgePlace& p) {
        constexpr int kParts = step::kEdgeParts;
        if (!p.there) return;
        const int part = threadIdx.x % kParts;
        step::EdgeMass mass = {0, 0, 0};
        if (p.to >= 0) {
            const unsigned group = ((1u << kParts) - 1) << (threadIdx.x % 32 / kParts * kParts);
            const step::Edge edge = step::edge_between(v, p.from, p.to);
            step::EdgeSums sums = step::edge_part(v, edge, part);
            for (int other = 1; other < kParts; other *= 2)
                sums = sums + step::EdgeSums{__shfl_xor_sync(group, sums.columns, other),
                                             __shfl_xor_sync(group, sums.within, other),
                                             __shfl_xor_sync(group, sums.mass, other),
                                             __shfl_xor_sync(group, sums.moment, other)};
            mass = step::mass_of(v, edge, sums);
        }
        if (part == 0) put_edge(v, p, mass);
    }
    __device__ __forceinline__ void put_edge(const step::BalanceView& v, const EdgePlace& p,
                                             const step::EdgeMass& mass) {
        if (p.j == 3) {
            v.right_flux[p.row] = mass.flux;
            team_.share(&v.right_flux[p.row], p.row, 1);
            return;
        }
        step::EdgeMass& edge = v.edges[3 * step::rim_slot(v, p.column, p.row) + p.j];
        edge = mass;
        team_.share(&edge, p.row, 3 * v.slots);
    }
    __device__ __forceinline__ void measure_shape(const step::BalanceView& v, const Place& p,
                                                  float inverse_threshold) {
        if (p.row < 0) return;
        const int i = index(p);
        if (p.inner)
            step::shape_inner(v, i, inverse_threshold, step::vertex_ring(lattice_.columns, p.row));
        else
            step::shape_border(v, p.column, p.row, inverse_threshold);
        for (float* const array : {v.inverse_xx, v.inverse_xy, v.inverse_yy, v.step_x, v.step_y})
            team_.share(array + i, p.row, lattice_.columns);
    }

    __device__ void gradients() {
        const step::BalanceView& v = view();
        const int rims = class_order_.count;
#pragma unroll 1
        for (int item = team_.thread; item < 2 * rims; item += team_.threads) {
            const int of_class = item < rims ? 1 : 2;
            const Place p = class_order_.at(item < rims ? item : item - rims, of_class);
            if (p.row < 0) continue;
            step::rim_gradient(v, p.column, p.row, of_class);
            const int i = 3 * index(p);
            for (int j = 0; j < 3; ++j) {
                team_.share(v.gradient_x + i + j, p.row, 3 * lattice_.columns);
                team_.share(v.gradient_y + i + j, p.row, 3 * lattice_.columns);
            }
        }
    }

    __device__ void solve(Equations<kResident>& equations, int t) {
        const step::BalanceView& v = view();
        std::int64_t sum = 0;
        each_cell([&](const CellPlace& cell) {
            const auto [column, row, full] = cell.place;
            step::CellEquation& e = equations.at(cell.item);
            if (full) {
                e = step::cell_equation<true>(v, column, row);
                sum += step::whole_weight(e.weight);
            } else {
                e = step::cell_equation<false>(v, column, row);
            }
        });
        const float target = step::target_weight(team_.sum(sum, t), job_.full_cells);
        each_cell([&](const CellPlace& cell) {
            step::close_equation(v, cell.place.column, cell.place.row, target, equations.at(cell.item));
            equations.direction_at(cell.item) = 0;
        });
        float *from = v.multiplier, *to = v.next_multiplier;
#pragma unroll 1
        for (int sweep = 0; sweep < job_.sweeps; ++sweep) {
            const SweepGain gain = job_.gains[sweep];
            each_cell([&](const CellPlace& cell) {
                to[cell.slot] = step::swept(equations.at(cell.item), from + cell.slot, cell.ring, gain.keep,
                                            gain.gain, equations.direction_at(cell.item));
                team_.share_far(&to[cell.slot], cell.place.row, v.stride);
            });
            float* const swap = from;
            from = to;
            to = swap;
            team_.wait();
        }
        state_ ^= job_.sweeps & 1;
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
#pragma unroll 1
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
    const Order order_, class_order_;
    const Place place_;
    const CellPlace cell_;
    int state_ = 0;
};

}  // namespace hexrelief::cuda
