#include "mesher/balance/balance.h"

#include <algorithm>
#include <atomic>

#include "mesher/balance/cell_equations_step.h"
#include "mesher/balance/convergence_step.h"
#include "mesher/balance/edge_integrals_simd.h"
#include "mesher/balance/plan.h"
#include "mesher/balance/triangle_distortion_step.h"
#include "pipeline/base/simd.h"

namespace hexrelief::balance {
namespace {

// Row-wise integrals of the density in whole numbers, with its total and the number of non-empty pixels.
struct Primitive {
    std::vector<double> sums;
    std::int64_t total = 0, filled = 0;
};

Primitive integrate_rows(const som::LevelPlan& plan, const std::vector<float>& density, ThreadPool& pool) {
    const int width = plan.width, height = plan.height;
    Primitive result;
    const float largest = *std::max_element(density.begin(), density.end());
    if (!(largest > 0)) return result;
    const double scale = step::mass_scale(largest);
    result.sums.resize(static_cast<std::size_t>(width + 1) * height);
    std::vector<std::int64_t> totals(height), filled(height);
    pool.parallel_for_each(height, [&](std::size_t y) {
        const float* const row = &density[y * width];
        double* const sums = &result.sums[y * (width + 1)];
        sums[0] = 0;
        std::int64_t sum = 0;
        for (int x = 0; x < width; ++x) {
            const std::int64_t mass = step::whole_mass(row[x], scale);
            sum += mass;
            sums[x + 1] = static_cast<double>(sum);
            filled[y] += mass > 0;
        }
        totals[y] = sum;
    });
    for (int y = 0; y < height; ++y) {
        result.total += totals[y];
        result.filled += filled[y];
    }
    return result;
}

// The equations of all cells, as a structure of arrays: each plane has one entry per padded cell.
struct CellPlanes {
    float *weight, *residual, *diagonal, *inverse, *direction;
    float* across;  // 6 planes
    int plane;
};

step::CellEquation load(const CellPlanes& c, int slot) {
    const auto across = [&](int k) { return c.across[k * c.plane + slot]; };
    return {c.weight[slot],
            c.residual[slot],
            c.diagonal[slot],
            c.inverse[slot],
            {across(0), across(1), across(2), across(3), across(4), across(5)}};
}

void store(const CellPlanes& c, int slot, const step::CellEquation& e) {
    c.weight[slot] = e.weight;
    c.residual[slot] = e.residual;
    c.diagonal[slot] = e.diagonal;
    c.inverse[slot] = e.inverse;
    for (int k = 0; k < 6; ++k) c.across[k * c.plane + slot] = e.across[k];
}

// Owns the arrays of a view.
struct Workspace {
    std::vector<float> vertices, padded;
    std::vector<double> right_flux, end_flux;
    std::vector<step::EdgeMass> edges;
    step::BalanceView view{};
    CellPlanes cells{};

    Workspace(const som::LevelPlan& plan, const BalanceConfig& config, bool pinned,
              const Primitive& primitive, som::LatticePositions& positions) {
        const std::size_t n = positions.x.size();
        view = balance_view(plan, config, pinned);
        view.primitive = primitive.sums.data();
        step::set_units(view, primitive.total, primitive.filled, config.floor);
        view.x = positions.x.data();
        view.y = positions.y.data();
        edges.resize(static_cast<std::size_t>(3) * view.slots * view.lattice.rows);
        view.edges = edges.data();
        right_flux.resize(view.lattice.rows);
        view.right_flux = right_flux.data();
        end_flux.resize(static_cast<std::size_t>(2) * view.lattice.columns);
        view.end_flux = end_flux.data();
        vertices.resize(14 * n);
        float* at = vertices.data();
        for (float** array : {&view.inverse_xx, &view.inverse_xy, &view.inverse_yy, &view.reach, &view.step_x,
                              &view.step_y, &view.scale, &view.next_scale})
            *array = at, at += n;
        view.gradient_x = at;
        view.gradient_y = at + 3 * n;
        const int plane = step::cell_plane(view);
        padded.resize(static_cast<std::size_t>(13) * plane);
        at = padded.data();
        for (float** array : {&view.multiplier, &view.next_multiplier, &cells.weight, &cells.residual,
                              &cells.diagonal, &cells.inverse, &cells.direction})
            *array = at, at += plane;
        cells.across = at;
        cells.plane = plane;
    }
};

// Computes the shapes of a row's inner vertices. The arrays of a view do not overlap; the compiler cannot
// know this, and without ivdep the loops stay scalar.
HEXRELIEF_VECTORS int shape_row(const step::BalanceView& view, int row, const step::ShapeLimits& limits) {
    const step::BalanceView v = view;
    const int columns = v.lattice.columns, first = row * columns;
    const step::VertexRing ring = step::vertex_ring(columns, row);
    int thin = 0;
#pragma GCC ivdep
    for (int i = first + 1; i < first + columns - 1; ++i) thin += step::shape_inner(v, i, limits, ring);
    return thin;
}

// Shrinks the steps of a row's vertices that spoil a triangle. Returns true if there are any.
HEXRELIEF_VECTORS bool shrink_row(const step::BalanceView& view, int row, int round) {
    const step::BalanceView v = view;
    const int columns = v.lattice.columns, first = row * columns;
    const step::VertexRing ring = step::vertex_ring(columns, row);
    const float factor = step::shrink_factor(round);
    int any = 0;
    const bool end = row == 0 || row == v.lattice.rows - 1;
    for (int c = 0; c < columns; c += end ? 1 : columns - 1) {
        const int spoils = step::spoils_any(v, c, row);
        v.next_scale[first + c] = v.scale[first + c] * (spoils ? factor : 1.0f);
        any |= spoils;
    }
    if (end) return any;
#pragma GCC ivdep
    for (int i = first + 1; i < first + columns - 1; ++i) {
        const int spoils = step::spoils_inner(v, i, ring);
        v.next_scale[i] = v.scale[i] * (spoils ? factor : 1.0f);
        any |= spoils;
    }
    return any;
}

// Makes one Chebyshev sweep for the cells of a row.
HEXRELIEF_VECTORS void sweep_row(const step::BalanceView& view, const CellPlanes& cells, int row,
                                 SweepGain gain) {
    const step::BalanceView v = view;
    const CellPlanes c = cells;
    const int first = (row + 2) * v.stride + 1;
    const step::CellRing ring = step::cell_ring(v, row);
#pragma GCC ivdep
    for (int slot = first; slot < first + v.slots; ++slot)
        v.next_multiplier[slot] = step::chebyshev_sweep(load(c, slot), v.multiplier + slot, ring, gain.keep,
                                                        gain.gain, c.direction[slot]);
}

// Runs the iterations of one level on all threads; `barrier` waits for the other threads.
template <typename Barrier>
class Balancer {
  public:
    Balancer(const Workspace& workspace, const step::BalanceLimits& limits, int sweeps, int threads,
             Barrier barrier)
        : view_(workspace.view),
          cells_(workspace.cells),
          limits_(limits),
          threads_(threads),
          full_cells_(full_cells(workspace.view.lattice)),
          gains_(chebyshev_gains(sweeps)),
          barrier_(barrier) {
        for (auto& sums : row_sums_) sums.resize(view_.lattice.rows);
    }

    void work(int thread) {
        step::BalanceView v = view_;
        const int rows = v.lattice.rows;
        const int first = rows * thread / threads_, last = rows * (thread + 1) / threads_;
        int checks = 0;
        float threshold = v.threshold, target = 1, deviation_before = 1e30f;
        for (int t = 0; t < limits_.most; ++t) {
            if (t > 0) {
                const step::BalanceSums sums = sums_of(t - 1);
                const float deviation = step::mean_weight(sums.deviation, full_cells_);
                const bool in_shape = !step::has_thin(v, sums.thin, step::kThinShare);
                if (step::is_done(limits_, t, deviation, target, in_shape, deviation_before)) break;
                threshold = step::next_threshold(v, sums.thin, step::is_late(limits_, t), threshold);
                target = step::mean_weight(sums.weight, full_cells_);
            }
            for (int row = first; row < last; ++row) measure_boundary_edges(v, row);
            for (int row = first; v.pinned && row < std::min(last, rows - 1); ++row)
                step::measure_right_edge(v, row);
            const int ends = step::is_bent(v.outline) ? 2 * (v.lattice.columns - 1) : 0;
            for (int k = ends * thread / threads_; k < ends * (thread + 1) / threads_; ++k)
                step::measure_end_edge(v, k);
            barrier_();
            const step::ShapeLimits limits = step::shape_limits(v, threshold, step::is_late(limits_, t));
            for (int row = first; row < last; ++row) row_sums_[t & 1][row] = {0, 0, shape(v, row, limits)};
            for (int i = first * v.lattice.columns; v.held && i < last * v.lattice.columns; ++i)
                if (v.held[i]) step::hold_vertex(v, i);
            each(first, last, 1, [&](int c, int r) { step::boundary_gradient(v, c, r, 1); });
            each(first, last, 2, [&](int c, int r) { step::boundary_gradient(v, c, r, 2); });
            barrier_();
            for (int row = first; row < last; ++row) equations(v, row, target, row_sums_[t & 1][row]);
            if (t == 0) {
                barrier_();
                target = step::mean_weight(sums_of(0).weight, full_cells_);
            }
            solve(v, first, last, target);
            for (int row = first; row < last; ++row)
                for (int c = 0; c < v.lattice.columns; ++c) step::propose_step(v, c, row);
            barrier_();
            move(v, thread, first, last, checks, true);
        }
        if (!step::is_bent(v.outline) || !limits_.finest) return;
        for (int row = first; row < last; ++row)
            for (int c = 0; c < v.lattice.columns; ++c) step::propose_lift(v, c, row);
        barrier_();
        move(v, thread, first, last, checks, false);
    }

  private:
    // Calls visit(column, row) for the vertices of one class in rows [first, last).
    template <typename Visit>
    void each(int first, int last, int of_class, const Visit& visit) const {
        for (int row = first; row < last; ++row) {
            int column = 0;
            while (step::honeycomb_class(column, row) != of_class) ++column;
            for (; column < view_.lattice.columns; column += 3) visit(column, row);
        }
    }

    // Returns the sums over all rows; valid once all threads have added theirs.
    step::BalanceSums sums_of(int t) const {
        step::BalanceSums sums{0, 0, 0};
        for (const step::BalanceSums& s : row_sums_[t & 1]) {
            sums.weight += s.weight;
            sums.deviation += s.deviation;
            sums.thin += s.thin;
        }
        return sums;
    }

    // Computes the shapes of a row's vertices. Returns the number of thin triangles, counted at each vertex.
    static int shape(const step::BalanceView& v, int row, const step::ShapeLimits& limits) {
        const int columns = v.lattice.columns;
        const bool end = row == 0 || row == v.lattice.rows - 1;
        int thin = end ? 0 : shape_row(v, row, limits);
        for (int c = 0; c < columns; c += end ? 1 : columns - 1) thin += step::shape_of(v, c, row, limits);
        return thin;
    }

    // Sets up the equations of a row's cells and adds their weights to the sums.
    void equations(const step::BalanceView& v, int row, float target, step::BalanceSums& sums) {
        each(row, row + 1, 0, [&](int c, int r) {
            if (!step::is_held_cell(v, c, r)) return;
            const bool full = step::is_full_cell(v.lattice, c, r);
            const step::CellEquation e =
                full ? step::cell_equation<true>(v, c, r) : step::cell_equation<false>(v, c, r);
            store(cells_, step::cell_slot(v, c, r), e);
            if (full) step::add_cell(e.weight, target, sums);
        });
    }

    // Completes the equations and solves them by Chebyshev sweeps.
    void solve(step::BalanceView& v, int first, int last, float target) {
        each(first, last, 0, [&](int c, int r) {
            if (!step::is_held_cell(v, c, r)) return;
            const int slot = step::cell_slot(v, c, r);
            step::CellEquation e = load(cells_, slot);
            step::close_equation(v, c, r, target, e);
            store(cells_, slot, e);
            cells_.direction[slot] = 0;
        });
        for (const SweepGain& gain : gains_) {
            for (int row = first; row < last; ++row) sweep_row(v, cells_, row, gain);
            std::swap(v.multiplier, v.next_multiplier);
            barrier_();
        }
    }

    // Takes the proposed steps, after shrinking those that would spoil a triangle.
    void move(step::BalanceView& v, int thread, int first, int last, int& checks, bool on_curve) {
        shrink(v, thread, first, last, checks);
        const int columns = v.lattice.columns;
        for (int i = first * columns; i < last * columns; ++i) step::take_step(v, i, on_curve);
        barrier_();
    }

    void shrink(step::BalanceView& v, int thread, int first, int last, int& checks) {
        for (int round = 0; round < step::kShrinkRounds; ++round, ++checks) {
            bool any = false;
            for (int row = first; row < last; ++row) any |= shrink_row(v, row, round);
            // three flags take turns: one is set, one may still be read, and one is cleared
            // for the next round
            std::atomic<bool>& flag = spoilt_[checks % 3];
            if (any) flag = true;
            if (thread == 0) spoilt_[(checks + 1) % 3] = false;
            barrier_();
            std::swap(v.scale, v.next_scale);
            if (!flag) {
                ++checks;
                break;
            }
        }
    }

    const step::BalanceView view_;
    const CellPlanes cells_;
    const step::BalanceLimits limits_;
    const int threads_, full_cells_;
    const std::vector<SweepGain> gains_;
    std::vector<step::BalanceSums> row_sums_[2];  // sums of even and of odd iterations
    std::atomic<bool> spoilt_[3] = {};
    Barrier barrier_;
};

}  // namespace

void balance_level(const som::LevelPlan& plan, const BalanceConfig& config, bool pinned,
                   const std::uint8_t* held, const std::vector<float>& density, ThreadPool& pool,
                   som::LatticePositions& positions) {
    const Primitive primitive = integrate_rows(plan, density, pool);
    if (primitive.total == 0 || full_cells(plan.lattice) == 0) return;
    som::untangle(plan, pinned, held, pool, positions);
    Workspace workspace(plan, config, pinned, primitive, positions);
    workspace.view.held = held;
    const step::BalanceLimits limits = balance_limits(config, plan.level);
    if (pool.size() > 1 && positions.x.size() >= kLeastSharedVertices) {
        const auto barrier = [&pool] { pool.barrier(); };
        Balancer balancer(workspace, limits, config.sweeps, pool.size(), barrier);
        pool.run([&](int thread) { balancer.work(thread); });
    } else {
        const auto none = [] {};
        Balancer(workspace, limits, config.sweeps, 1, none).work(0);
    }
    som::untangle(plan, pinned, held, pool, positions);
}

som::LevelPlan patch_plan(const DensityMap& density, const LatticePatch& patch) {
    som::LevelPlan plan;
    plan.width = density.width;
    plan.height = density.height;
    plan.extent_x = static_cast<float>(density.width);
    plan.extent_y = static_cast<float>(density.height);
    plan.lattice = {patch.mesh.columns, patch.mesh.rows};
    return plan;
}

std::vector<std::uint8_t> held_with_border(const LatticePatch& patch) {
    std::vector<std::uint8_t> held = patch.held;
    for (int row = 0; row < patch.mesh.rows; ++row)
        for (int column = 0; column < patch.mesh.columns; ++column)
            if (!step::is_full_cell({patch.mesh.columns, patch.mesh.rows}, column, row))
                held[patch.mesh.index(column, row)] = 1;
    return held;
}

void balance_patch(const DensityMap& density, const BalanceConfig& config, int threads, LatticePatch& patch) {
    const som::LevelPlan plan = patch_plan(density, patch);
    som::LatticePositions positions;
    for (const Vec2f& p : patch.mesh.positions) positions.x.push_back(p.x), positions.y.push_back(p.y);
    ThreadPool pool(threads);
    // The border may be folded against held vertices next to it, so it is untangled first; from
    // then on it stays.
    som::untangle(plan, false, patch.held.data(), pool, positions);
    balance_level(plan, config, false, held_with_border(patch).data(), density.values, pool, positions);
    for (std::size_t i = 0; i < positions.x.size(); ++i)
        patch.mesh.positions[i] = {positions.x[i], positions.y[i]};
}

}  // namespace hexrelief::balance
