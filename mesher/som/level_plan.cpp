#include "mesher/som/level_plan.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "mesher/som/learning_step.h"
#include "pipeline/data/error.h"
#include "pipeline/data/number_text.h"

namespace hexrelief::som {
namespace {

// Coarser lattices have too few vertices for a neighbourhood to order: with 5 columns and radius 6 a
// map came out mirrored.
constexpr int kLeastCoarseSide = 12;

// Interpolates geometrically: `from` at share 0, `to` at share 1.
double geometric(double from, double to, double share) {
    return from * std::pow(to / from, share);
}

// Returns the number of levels: the given one or as many as fit, while the coarsest lattice has at least
// kLeastCoarseSide columns and rows.
int level_count(int width, int height, const MeshConfig& config) {
    if (config.method == MeshMethod::sequential) return 1;
    int levels = 1;
    const auto fits = [&](int level) {
        const double spacing = config.spacing_px * std::ldexp(1.0, level);
        const step::Lattice lattice = lattice_size(width, height, spacing);
        return std::min(lattice.columns, lattice.rows) >= kLeastCoarseSide;
    };
    const int most = config.levels > 0 ? config.levels : 16;
    while (levels < most && fits(levels)) ++levels;
    return levels;
}

}  // namespace

step::Lattice lattice_size(double width, double height, double spacing_px) {
    const auto count = [&](double size) {
        return std::max(3, static_cast<int>(std::floor(size / spacing_px + 0.5)));
    };
    return {count(width), count(height)};
}

LearningTables learning_tables(double alpha, double sigma) {
    LearningTables tables;
    tables.radius = static_cast<int>(std::floor(sigma));
    for (int d = 0; d <= tables.radius; ++d) {
        const double h = std::exp(-static_cast<double>(d) * d / (sigma * sigma));
        const double a = std::min(1.0, alpha * h);
        const double decay = a < 1 ? -std::log2(1 - a) * (1 << step::kDecayBits) : step::kFullDecay;
        tables.gain.push_back(static_cast<std::uint32_t>(std::lround(h * (1 << step::kGainBits))));
        tables.decay.push_back(
            static_cast<std::uint32_t>(std::lround(std::min<double>(decay, step::kFullDecay))));
    }
    return tables;
}

int batch_length(const MeshConfig& config, double share) {
    const double wanted = config.prr_final > 0 ? geometric(config.prr, config.prr_final, share) : config.prr;
    const int most = std::min({static_cast<int>(wanted + 1e-9), kMostBatch, config.crr});
    const int batches = (config.crr + most - 1) / most;
    return (config.crr + batches - 1) / batches;
}

std::vector<LevelPlan> plan_levels(int width, int height, const MeshConfig& config, const MeshArea& area) {
    const double least = 3 * config.spacing_px;
    if (width < least || height < least)
        throw Error(ErrorKind::usage, "mesh.spacing_px: " + number_text(config.spacing_px) +
                                          " is too large for an image of " + std::to_string(width) + "x" +
                                          std::to_string(height) + " px; three spacings must fit each way");
    const int count = level_count(width, height, config);
    std::vector<LevelPlan> plans;
    for (int level = count - 1; level >= 0; --level) {
        LevelPlan plan;
        plan.level = level;
        const double scale = std::ldexp(1.0, level);
        plan.extent_x = static_cast<float>(area.width / scale);
        plan.extent_y = static_cast<float>(area.height / scale);
        plan.width = static_cast<int>(std::ceil(area.width / scale));
        plan.height = static_cast<int>(std::ceil(area.height / scale));
        plan.lattice = lattice_size(width, height, config.spacing_px * scale);
        plan.cells = step::make_cell_grid(plan.width, plan.height, config.co);
        plan.draws = static_cast<int>(std::ceil(config.delta));
        const int index = count - 1 - level;
        const double sigma_limit = std::min(plan.lattice.columns, plan.lattice.rows) / 2.0;
        const double from = std::min(sigma_limit, index == 0 ? config.sigma_init : config.sigma_level_init);
        const double to = std::min(sigma_limit, level == 0 ? config.sigma_final : config.sigma_level_final);
        for (int t = 0; t < config.t_max; ++t) {
            const double level_share = static_cast<double>(t) / config.t_max;
            const double alpha =
                geometric(config.alpha_init, config.alpha_final, (index + level_share) / count);
            plan.iterations.push_back(learning_tables(alpha, geometric(from, to, level_share)));
            plan.batches.push_back(t % config.crr ? plan.batches.back()
                                                  : batch_length(config, (index + level_share) / count));
        }
        plans.push_back(std::move(plan));
    }
    return plans;
}

std::vector<float> magnification_table(double exponent) {
    std::vector<float> table;
    if (exponent == 1) return table;
    for (int i = 0; i <= kMagnificationSteps; ++i)
        table.push_back(static_cast<float>(std::pow(static_cast<double>(i) / kMagnificationSteps, exponent)));
    return table;
}

}  // namespace hexrelief::som
