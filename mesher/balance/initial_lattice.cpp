#include "mesher/balance/initial_lattice.h"

#include <algorithm>

#include "mesher/balance/cell_mass_step.h"
#include "mesher/balance/initial_lattice_step.h"

namespace hexrelief::balance {
namespace {

// Returns the prefix sums of `masses`, each with its part of the evenly spread mass added; starts with 0.
std::vector<std::int64_t> sums_of(const std::vector<std::int64_t>& masses, std::int64_t total) {
    const std::int64_t even = step::even_mass(total, static_cast<int>(masses.size()));
    std::vector<std::int64_t> sums{0};
    for (const std::int64_t mass : masses) sums.push_back(sums.back() + mass + even);
    return sums;
}

}  // namespace

void equalise_start(const som::LevelPlan& plan, const std::vector<float>& density,
                    som::LatticePositions& positions) {
    const float largest = *std::max_element(density.begin(), density.end());
    if (!(largest > 0)) return;
    const double scale = step::mass_scale(largest);
    std::vector<std::int64_t> columns(plan.width), rows(plan.height);
    std::int64_t total = 0;
    for (int y = 0; y < plan.height; ++y) {
        const float* const row = &density[static_cast<std::size_t>(y) * plan.width];
        for (int x = 0; x < plan.width; ++x) {
            const std::int64_t mass = step::whole_mass(row[x], scale);
            columns[x] += mass;
            rows[y] += mass;
        }
        total += rows[y];
    }
    const std::vector<std::int64_t> across = sums_of(columns, total), down = sums_of(rows, total);
    const step::Border border = som::border_of(plan);
    for (std::size_t i = 0; i < positions.x.size(); ++i) {
        float &x = positions.x[i], &y = positions.y[i];
        x = step::equalised(across.data(), plan.width, x / plan.extent_x, plan.extent_x);
        y = step::equalised(down.data(), plan.height, y / plan.extent_y, plan.extent_y);
        const int at = static_cast<int>(i), row = at / plan.lattice.columns;
        step::bend_start(border, at % plan.lattice.columns, row, x, y);
    }
}

}  // namespace hexrelief::balance
