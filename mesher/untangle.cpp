#include <algorithm>
#include <cstdint>

#include "mesher/cellular_som.h"
#include "mesher/steps/untangle.h"

namespace hexrelief {

int untangle(const step::Lattice& lattice, int threads, LatticePositions& positions) {
    const int columns = lattice.columns, rows = lattice.rows;
    std::vector<std::uint8_t> smoothed(positions.x.size(), 0);
    LatticePositions next;
    for (int sweep = 0; sweep < step::kMostUntangleSweeps; ++sweep) {
        const step::LatticeView view{columns, rows, positions.x.data(), positions.y.data()};
        int any = 0;
#pragma omp parallel for num_threads(threads) reduction(| : any)
        for (int row = 0; row < rows; ++row)
            for (int column = 0; column < columns; ++column)
                if (step::folded(view, column, row)) any |= smoothed[static_cast<std::size_t>(row) * columns + column] = 1;
        if (!any) return sweep;
        if (sweep % step::kUntangleGrowth == step::kUntangleGrowth - 1) {
            const std::vector<std::uint8_t> before = smoothed;
            for (int row = 0; row < rows; ++row)
                for (int column = 0; column < columns; ++column)
                    for (int k = 0; k < 6; ++k) {
                        const int i = step::neighbour(view, column, row, k);
                        if (i >= 0 && before[i]) smoothed[static_cast<std::size_t>(row) * columns + column] = 1;
                    }
        }
        next = positions;
#pragma omp parallel for num_threads(threads)
        for (int row = 0; row < rows; ++row)
            for (int column = 0; column < columns; ++column) {
                const std::size_t i = static_cast<std::size_t>(row) * columns + column;
                if (smoothed[i]) step::neighbour_mean(view, column, row, next.x[i], next.y[i]);
            }
        std::swap(positions, next);
    }
    return step::kMostUntangleSweeps;
}

}  // namespace hexrelief
