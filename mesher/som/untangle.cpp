#include <atomic>
#include <cstdint>

#include "mesher/som/cellular_som.h"
#include "mesher/som/untangle_step.h"

namespace hexrelief::som {

// Marks vertices of folded triangles and smooths all marked ones, sweep by sweep. Marks remain from sweep to
// sweep and spread to neighbours every kUntangleGrowth sweeps.
int untangle(const LevelPlan& plan, bool pinned, const std::uint8_t* held, ThreadPool& pool,
             LatticePositions& positions) {
    const int columns = plan.lattice.columns, rows = plan.lattice.rows;
    std::vector<std::uint8_t> smoothed(positions.x.size(), 0);
    LatticePositions next;
    const step::BorderHold border{pinned, plan.outline};
    const auto each_vertex = [&](const auto& visit) {
        pool.parallel_for_each(rows, [&](int row) {
            for (int column = 0; column < columns; ++column)
                visit(column, row, static_cast<std::size_t>(row) * columns + column);
        });
    };
    for (int sweep = 0; sweep < step::kMostUntangleSweeps; ++sweep) {
        const step::LatticeView view{columns, rows, positions.x.data(), positions.y.data()};
        std::atomic<bool> any = false;
        each_vertex([&](int column, int row, std::size_t i) {
            if (!step::folded(view, column, row)) return;
            smoothed[i] = 1;
            any = true;
        });
        if (!any) return sweep;
        if (sweep % step::kUntangleGrowth == step::kUntangleGrowth - 1) {
            const std::vector<std::uint8_t> before = smoothed;
            each_vertex([&](int column, int row, std::size_t i) {
                for (int k = 0; k < 6; ++k) {
                    const int n = step::neighbour(view, column, row, k);
                    if (n >= 0 && before[n]) smoothed[i] = 1;
                }
            });
        }
        next = positions;
        each_vertex([&](int column, int row, std::size_t i) {
            if (!smoothed[i] || (held && held[i])) return;
            const step::Position p = step::smoothed_position(view, border, sweep, column, row);
            next.x[i] = p.x;
            next.y[i] = p.y;
        });
        std::swap(positions, next);
    }
    return step::kMostUntangleSweeps;
}

}  // namespace hexrelief::som
