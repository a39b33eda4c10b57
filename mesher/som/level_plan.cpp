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

// Largest ratio of the lattice's spacings in the two directions; with it the regular lattice has angles of 27
// degrees. A larger ratio would keep less of the empty surroundings of a thin map in the mesh, but its
// triangles would stay thin.
constexpr double kMostStretch = 2;

constexpr double kMostBend = 0.25;  // largest bend of either border, as a share of the area's height
// steeper curves leave folds that take hundreds of sweeps to repair
constexpr float kMostOutlineSlope = 1.4f;
// The margin kept around density, and half the width of the window that rounds valleys, in spacings.
constexpr double kMargin = 2, kRounding = 8;

// Counts the empty pixels of each column of the area from its upper side downwards (from_below: from its
// lower side upwards), up to `most`.
std::vector<int> empty_rows(const DensityMap& density, const MeshArea& area, int most, bool from_below) {
    std::vector<int> empty(area.width, most);
    int left = area.width;
    for (int k = 0; k < most && left > 0; ++k) {
        const int y = area.y + (from_below ? area.height - 1 - k : k);
        const float* const row = &density.values[static_cast<std::size_t>(y) * density.width + area.x];
        for (int x = 0; x < area.width; ++x)
            if (empty[x] == most && row[x] > 0) {
                empty[x] = k;
                --left;
            }
    }
    return empty;
}

// Returns how far a border bends inwards at x = 0, 1, .. width, px.
std::vector<float> bend(const std::vector<int>& empty, int margin, int rounding, float slope) {
    const int width = static_cast<int>(empty.size());
    std::vector<float> depth(width + 1);
    for (int k = 0; k <= width; ++k) {
        const auto from = empty.begin() + std::max(k - 1 - margin, 0),
                   to = empty.begin() + std::min(k + 1 + margin, width);
        depth[k] = static_cast<float>(*std::min_element(from, to));
    }
    for (int k = 1; k <= width; ++k) depth[k] = std::min(depth[k], depth[k - 1] + slope);
    for (int k = width; k > 0; --k) depth[k - 1] = std::min(depth[k - 1], depth[k] + slope);
    // the depth is limited to the mean around it, which rounds the bottom of a valley
    std::vector<float> rounded(width + 1);
    const auto at = [&](int k) { return static_cast<double>(depth[std::clamp(k, 0, width)]); };
    double sum = 0;
    for (int k = -rounding; k < rounding; ++k) sum += at(k);
    for (int k = 0; k <= width; ++k) {
        sum += at(k + rounding);
        rounded[k] = std::min(depth[k], static_cast<float>(sum / (2 * rounding + 1)));
        sum -= at(k - rounding);
    }
    return rounded;
}

// Grows [first, end) evenly on both sides to `length`, within [0, limit).
void grow(int& first, int& end, int length, int limit) {
    if (end - first >= length) return;
    first = std::clamp(first - (length - (end - first)) / 2, 0, limit - length);
    end = first + length;
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

MeshArea mesh_area(const DensityMap& density, const MeshConfig& config) {
    const int width = density.width, height = density.height;
    const MeshArea whole{0, 0, width, height};
    if (config.border != MeshBorder::fit) return whole;
    const auto row = [&](int y) { return &density.values[static_cast<std::size_t>(y) * width]; };
    const auto empty = [&](int y) {
        return std::none_of(row(y), row(y) + width, [](float d) { return d > 0; });
    };
    int left = width, right = 0, top = 0, bottom = height;
    while (top < bottom && empty(top)) ++top;
    while (bottom > top && empty(bottom - 1)) --bottom;
    for (int y = top; y < bottom; ++y) {
        left = static_cast<int>(std::find_if(row(y), row(y) + left, [](float d) { return d > 0; }) - row(y));
        int last = width;
        while (last > right && !(row(y)[last - 1] > 0)) --last;
        right = last;
    }
    if (top == bottom) return whole;
    const step::Lattice lattice = lattice_size(width, height, config.spacing_px);
    const auto ceil_to = [](double length, int limit) {
        return std::min(static_cast<int>(std::ceil(length)), limit);
    };
    grow(left, right, std::min(lattice.columns, width), width);
    grow(top, bottom, std::min(lattice.rows, height), height);
    const double across = static_cast<double>(right - left) / lattice.columns,
                 down = static_cast<double>(bottom - top) / lattice.rows;
    grow(left, right, ceil_to(down / kMostStretch * lattice.columns, width), width);
    grow(top, bottom, ceil_to(across / kMostStretch * lattice.rows, height), height);
    return {left, top, right - left, bottom - top};
}

MeshOutline mesh_outline(const DensityMap& density, const MeshArea& area, const MeshConfig& config) {
    MeshOutline outline;
    if (config.border != MeshBorder::fit || !config.balance.enabled || config.method != MeshMethod::cellular)
        return outline;
    const int most = static_cast<int>(area.height * kMostBend);
    const int margin = static_cast<int>(kMargin * config.spacing_px),
              rounding = static_cast<int>(kRounding * config.spacing_px);
    const auto side = [&](bool from_below) {
        return bend(empty_rows(density, area, most, from_below), margin, rounding, kMostOutlineSlope);
    };
    std::vector<float> upper = side(false), lower = side(true);
    const auto deepest = [](const std::vector<float>& depths) {
        return *std::max_element(depths.begin(), depths.end());
    };
    if (std::max(deepest(upper), deepest(lower)) < config.spacing_px) return outline;
    const auto is_empty = [](float d) { return !(d > 0); };
    if (std::all_of(density.values.begin(), density.values.end(), is_empty)) return outline;
    for (float& y : lower) y = static_cast<float>(area.height) - y;
    return {std::move(upper), std::move(lower)};
}

step::Outline outline_of(const MeshOutline& outline, const float* upper, const float* lower, int level) {
    if (outline.upper.empty()) return {};
    const float finest = static_cast<float>(std::ldexp(1.0, level));
    return {upper, lower, static_cast<int>(outline.upper.size()) - 1, finest, 1 / finest};
}

std::vector<float> density_within(const DensityMap& density, const MeshArea& area) {
    std::vector<float> values(static_cast<std::size_t>(area.width) * area.height);
    for (int y = 0; y < area.height; ++y) {
        const auto from =
            density.values.begin() + static_cast<std::ptrdiff_t>(area.y + y) * density.width + area.x;
        std::copy(from, from + area.width, values.begin() + static_cast<std::ptrdiff_t>(y) * area.width);
    }
    return values;
}

}  // namespace hexrelief::som
