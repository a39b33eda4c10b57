#include "mesher/balance.h"

#include <algorithm>
#include <atomic>

#include "mesher/steps/balance.h"
#include "mesher/steps/balance_move.h"
#include "mesher/steps/balance_plan.h"

namespace hexrelief {
namespace {

constexpr int kMostIterations = 300;
constexpr int kCoarserIterations = 3;

// Row-wise inclusive integrals of the density; returns them with their total and the number of pixels > 0.
struct Primitive {
    std::vector<double> sums;
    double total = 0;
    long long filled = 0;
};

Primitive integrate_rows(const LevelPlan& plan, const std::vector<float>& density, Team& team) {
    const int width = plan.width, height = plan.height;
    Primitive result;
    result.sums.resize(static_cast<std::size_t>(width + 1) * height);
    std::vector<long long> filled(height);
    team.for_ranges(height, [&](std::size_t first, std::size_t last) {
        for (std::size_t y = first; y < last; ++y) {
            const float* const row = &density[y * width];
            double* const sums = &result.sums[y * (width + 1)];
            sums[0] = 0;
            long long count = 0;
            for (int x = 0; x < width; ++x) {
                sums[x + 1] = sums[x] + row[x];
                count += row[x] > 0;
            }
            filled[y] = count;
        }
    });
    for (int y = 0; y < height; ++y) {
        result.total += result.sums[static_cast<std::size_t>(y) * (width + 1) + width];
        result.filled += filled[y];
    }
    return result;
}

// Owns the arrays of a view.
struct Workspace {
    std::vector<float> vertices, cells;
    std::vector<step::EdgeMass> edges;
    step::BalanceView view{};

    Workspace(const LevelPlan& plan, const BalanceConfig& config, bool pinned, const Primitive& primitive,
              LatticePositions& positions) {
        const step::Lattice lattice = plan.lattice;
        const std::size_t n = positions.x.size();
        view.lattice = lattice;
        view.extent_x = plan.extent_x;
        view.extent_y = plan.extent_y;
        view.pinned = pinned;
        view.slots = (lattice.columns + 2) / 3;
        view.stride = view.slots + 2;
        view.threshold = static_cast<float>(distortion_of_angle(config.least_angle_deg));
        view.width = plan.width;
        view.height = plan.height;
        view.primitive = primitive.sums.data();
        view.unit = (lattice.columns - 1.0) * (lattice.rows - 1.0) / (3 * primitive.total);
        view.floor = static_cast<float>(config.floor * primitive.total /
                                        static_cast<double>(primitive.filled) * view.unit);
        view.x = positions.x.data();
        view.y = positions.y.data();
        edges.resize(static_cast<std::size_t>(3) * view.slots * lattice.rows);
        view.edges = edges.data();
        vertices.resize(14 * n);
        float* at = vertices.data();
        for (float** array : {&view.inverse_xx, &view.inverse_xy, &view.inverse_yy, &view.reach, &view.step_x,
                              &view.step_y, &view.scale, &view.next_scale})
            *array = at, at += n;
        view.gradient_x = at;
        view.gradient_y = at + 3 * n;
        const std::size_t plane = step::cell_plane(view);
        cells.resize(13 * plane);
        at = cells.data();
        for (float** array : {&view.weight, &view.residual, &view.diagonal, &view.inverse, &view.multiplier,
                              &view.next_multiplier, &view.direction})
            *array = at, at += plane;
        view.across = at;
    }
};

// The arrays of a view do not overlap, which the compiler cannot know; without it the loops stay scalar.
__attribute__((target_clones("avx512f", "avx2", "default"))) void shape_row(const step::BalanceView& view,
                                                                            int row) {
    const step::BalanceView v = view;
    const int columns = v.lattice.columns, first = row * columns;
    const float inverse_threshold = 1.0f / v.threshold;
    const step::VertexRing ring = step::vertex_ring(columns, row);
#pragma GCC ivdep
    for (int i = first + 1; i < first + columns - 1; ++i) step::shape_inner(v, i, inverse_threshold, ring);
}

// Returns whether any vertex spoils a triangle.
__attribute__((target_clones("avx512f", "avx2", "default"))) bool shrink_row(const step::BalanceView& view,
                                                                             int row, int round) {
    const step::BalanceView v = view;
    const int columns = v.lattice.columns, first = row * columns;
    const step::VertexRing ring = step::vertex_ring(columns, row);
    const float factor = step::shrink_factor(round);
    int any = 0;
    const bool end = row == 0 || row == v.lattice.rows - 1;
    for (int c = 0; c < columns; c += end ? 1 : columns - 1) {
        const int spoils = step::spoils_border(v, c, row);
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

__attribute__((target_clones("avx512f", "avx2", "default"))) void sweep_row(const step::BalanceView& view,
                                                                            int row, SweepGain gain) {
    const step::BalanceView v = view;
    const int first = (row + 2) * v.stride + 1, plane = step::cell_plane(v);
    const step::CellRing ring = step::cell_ring(v, row);
#pragma GCC ivdep
    for (int slot = first; slot < first + v.slots; ++slot)
        step::sweep_cell(v, slot, plane, ring, gain.keep, gain.gain);
}

// The work of all threads; `barrier` waits for the others.
template <typename Barrier>
class Balancer {
  public:
    Balancer(const step::BalanceView& view, int iterations, int sweeps, int threads, Barrier barrier)
        : view_(view),
          iterations_(iterations),
          threads_(threads),
          full_cells_(full_cells(view.lattice)),
          gains_(chebyshev_gains(sweeps)),
          row_mass_(view.lattice.rows),
          barrier_(barrier) {}

    void work(int thread) {
        step::BalanceView v = view_;
        const int rows = v.lattice.rows;
        const int first = rows * thread / threads_, last = rows * (thread + 1) / threads_;
        int checks = 0;
        for (int t = 0; t < iterations_; ++t) {
            each(first, last, 1, [&](int c, int r) { step::measure_rim_edges(v, c, r); });
            barrier_();
            for (int row = first; row < last; ++row) shape(v, row);
            each(first, last, 1, [&](int c, int r) { step::rim_gradient(v, c, r, 1); });
            each(first, last, 2, [&](int c, int r) { step::rim_gradient(v, c, r, 2); });
            barrier_();
            for (int row = first; row < last; ++row) equations(v, row);
            barrier_();
            solve(v, first, last);
            for (int row = first; row < last; ++row)
                for (int c = 0; c < v.lattice.columns; ++c) step::propose_step(v, c, row);
            barrier_();
            shrink(v, thread, first, last, checks);
            const int columns = v.lattice.columns;
            for (int i = first * columns; i < last * columns; ++i) step::take_step(v, i);
            barrier_();
        }
    }

  private:
    template <typename Visit>
    void each(int first, int last, int of_class, const Visit& visit) const {
        for (int row = first; row < last; ++row) {
            int column = 0;
            while (step::honeycomb_class(column, row) != of_class) ++column;
            for (; column < view_.lattice.columns; column += 3) visit(column, row);
        }
    }

    static void shape(const step::BalanceView& v, int row) {
        const int columns = v.lattice.columns;
        const float inverse_threshold = 1.0f / v.threshold;
        const bool end = row == 0 || row == v.lattice.rows - 1;
        if (!end) shape_row(v, row);
        for (int c = 0; c < columns; c += end ? 1 : columns - 1)
            step::shape_border(v, c, row, inverse_threshold);
    }

    void equations(const step::BalanceView& v, int row) {
        double mass = 0;
        each(row, row + 1, 0, [&](int c, int r) {
            if (!step::is_held_cell(v, c, r)) return;
            step::cell_equation(v, c, r);
            if (step::is_full_cell(v.lattice, c, r)) mass += v.weight[step::cell_slot(v, c, r)];
        });
        row_mass_[row] = mass;
    }

    void solve(step::BalanceView& v, int first, int last) {
        double mass = 0;
        for (const double m : row_mass_) mass += m;
        const float target = static_cast<float>(mass / full_cells_);
        each(first, last, 0, [&](int c, int r) {
            if (step::is_held_cell(v, c, r)) step::close_equation(v, c, r, target, gains_[0].gain);
        });
        barrier_();
        for (std::size_t k = 1; k < gains_.size(); ++k) {
            for (int row = first; row < last; ++row) sweep_row(v, row, gains_[k]);
            std::swap(v.multiplier, v.next_multiplier);
            barrier_();
        }
    }

    void shrink(step::BalanceView& v, int thread, int first, int last, int& checks) {
        for (int round = 0; round < step::kShrinkRounds; ++round, ++checks) {
            bool any = false;
            for (int row = first; row < last; ++row) any |= shrink_row(v, row, round);
            // three flags in turn: one is set, one may still be read, one is cleared for the next round
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
    const int iterations_, threads_, full_cells_;
    const std::vector<SweepGain> gains_;
    std::vector<double> row_mass_;
    std::atomic<bool> spoilt_[3] = {};
    Barrier barrier_;
};

}  // namespace

int balance_iterations(const BalanceConfig& config, int level) {
    int iterations = config.iterations;
    for (int i = 0; i < level && iterations < kMostIterations; ++i) iterations *= kCoarserIterations;
    return level == 0 ? iterations : std::min(iterations, std::max(config.iterations, kMostIterations));
}

void balance_level(const LevelPlan& plan, const BalanceConfig& config, bool pinned,
                   const std::vector<float>& density, Team& team, LatticePositions& positions) {
    const Primitive primitive = integrate_rows(plan, density, team);
    if (!(primitive.total > 0) || full_cells(plan.lattice) == 0) return;
    untangle(plan, pinned, team, positions);
    Workspace workspace(plan, config, pinned, primitive, positions);
    const int iterations = balance_iterations(config, plan.level);
    if (team.size() > 1 && positions.x.size() >= kLeastSharedVertices) {
        const auto barrier = [&team] { team.barrier(); };
        Balancer balancer(workspace.view, iterations, config.sweeps, team.size(), barrier);
        team.run([&](int thread) { balancer.work(thread); });
    } else {
        const auto none = [] {};
        Balancer(workspace.view, iterations, config.sweeps, 1, none).work(0);
    }
    untangle(plan, pinned, team, positions);
}

}  // namespace hexrelief
