#include "mesher/som/sequential_som.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "mesher/common/lattice_step.h"
#include "mesher/som/best_matching_unit_step.h"

namespace hexrelief::som {
namespace {

// Returns the cumulative distribution over all pixels (Eq. 5); the densest pixel adds 2^32 - 1.
std::vector<std::uint64_t> cumulative_density(const std::vector<float>& density) {
    const double largest = *std::max_element(density.begin(), density.end());
    std::vector<std::uint64_t> cumulative(density.size());
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < density.size(); ++i) {
        if (largest > 0) sum += static_cast<std::uint64_t>(density[i] / largest * 4294967295.0 + 0.5);
        cumulative[i] = sum;
    }
    return cumulative;
}

// The neurons sorted into cells: those of cell c are ids[start[c] .. start[c + 1]).
struct CellIndex {
    std::vector<std::uint32_t> start, ids;
    CellIndex(const step::CellGrid& grid, const LatticePositions& positions) {
        std::vector<std::vector<std::uint32_t>> cells(static_cast<std::size_t>(grid.columns) * grid.rows);
        for (std::size_t i = 0; i < positions.x.size(); ++i)
            cells[step::cell_of(grid, positions.x[i], positions.y[i])].push_back(
                static_cast<std::uint32_t>(i));
        for (const auto& cell : cells) {
            start.push_back(static_cast<std::uint32_t>(ids.size()));
            ids.insert(ids.end(), cell.begin(), cell.end());
        }
        start.push_back(static_cast<std::uint32_t>(ids.size()));
    }
};

// Applies Eq. 3 for one point: a neuron at lattice distance d <= radius from the unit moves
// by share[d] towards it.
void learn(const step::Lattice& lattice, int unit, const step::HalfPoint& point,
           const std::vector<float>& share, LatticePositions& positions) {
    const int column = unit % lattice.columns, row = unit / lattice.columns;
    const int radius = static_cast<int>(share.size()) - 1;
    const float px = static_cast<float>(point.x) * 0.5f, py = static_cast<float>(point.y) * 0.5f;
    for (int r = std::max(0, row - radius); r <= std::min(lattice.rows - 1, row + radius); ++r) {
        const step::RowSpan span = step::row_span(column, row, radius, r);
        for (int i = std::max(0, -span.first); i < std::min(span.length, lattice.columns - span.first); ++i) {
            const std::size_t n = static_cast<std::size_t>(r) * lattice.columns + span.first + i;
            const float a = share[step::span_distance(span, radius, i)];
            positions.x[n] += a * (px - positions.x[n]);
            positions.y[n] += a * (py - positions.y[n]);
        }
    }
}

}  // namespace

LatticePositions train_sequential(const std::vector<float>& density, const LevelPlan& plan,
                                  const MeshConfig& config, const ProgressFunction& progress) {
    LatticePositions positions = regular_positions(plan);
    const std::vector<std::uint64_t> cumulative = cumulative_density(density);
    if (cumulative.back() == 0) return positions;
    std::mt19937_64 random(config.seed);  // a sequence that the C++ standard fixes
    const int cells = plan.cells.columns * plan.cells.rows;
    CellIndex index(plan.cells, positions);
    for (int t = 0; t < config.t_max; ++t) {
        if (progress && t % 16 == 0) progress(static_cast<double>(t) / config.t_max);
        if (t % config.crr == 0) index = CellIndex(plan.cells, positions);
        const double elapsed = static_cast<double>(t) / config.t_max;
        const double alpha = config.alpha_init * std::pow(config.alpha_final / config.alpha_init, elapsed);
        const double sigma = config.sigma_init * std::pow(config.sigma_final / config.sigma_init, elapsed);
        const int radius = static_cast<int>(sigma);
        std::vector<float> share;
        for (int d = 0; d <= radius; ++d)
            share.push_back(static_cast<float>(alpha * std::exp(-d * d / (sigma * sigma))));
        for (int draw = 0; draw < cells; ++draw) {
            // a modulo bias of less than back() / 2^64
            const std::uint64_t drawn = random() % cumulative.back();
            const auto pixel =
                std::upper_bound(cumulative.begin(), cumulative.end(), drawn) - cumulative.begin();
            const step::HalfPoint point{static_cast<int>(2 * (pixel % plan.width) + 1),
                                        static_cast<int>(2 * (pixel / plan.width) + 1)};
            const step::Candidate best = step::spiral_search(
                plan.cells, {index.start.data(), index.start.data() + 1, index.ids.data()},
                positions.x.data(), positions.y.data(), point, config.ssr);
            if (best.neuron != step::kNoNeuron)
                learn(plan.lattice, static_cast<int>(best.neuron), point, share, positions);
        }
    }
    return positions;
}

}  // namespace hexrelief::som
