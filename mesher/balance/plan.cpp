#include "mesher/balance/plan.h"

#include <algorithm>
#include <cmath>

#include "mesher/balance/cell_equations_step.h"
#include "mesher/balance/initial_lattice_step.h"

namespace hexrelief::balance {
namespace {

// Largest number of iterations of a level that is far from balance, as a multiple of the planned number.
constexpr int kMostOfPlanned = 8;

// Angles below which triangles resist, as shares of the smallest angle wanted: start value and range.
constexpr double kFirstAngle = 0.89, kSmallestAngle = 0.815, kLargestAngle = 1.235;

// Returns the prefix sums of `masses`, each with its part of the evenly spread mass added; starts with 0.
std::vector<std::int64_t> sums_of(const std::vector<std::int64_t>& masses, std::int64_t total) {
    const std::int64_t even = step::even_mass(total, static_cast<int>(masses.size()));
    std::vector<std::int64_t> sums{0};
    for (const std::int64_t mass : masses) sums.push_back(sums.back() + mass + even);
    return sums;
}

}  // namespace

std::vector<SweepGain> chebyshev_gains(int sweeps) {
    const double highest = 1, lowest = 0.02;
    const double middle = (highest + lowest) / 2, half = (highest - lowest) / 2, ratio = middle / half;
    std::vector<SweepGain> gains{{0.0f, static_cast<float>(1 / middle)}};
    double rho = 1 / ratio;
    for (int sweep = 1; sweep < sweeps; ++sweep) {
        const double next = 1 / (2 * ratio - rho);
        gains.push_back({static_cast<float>(next * rho), static_cast<float>(2 * next / half)});
        rho = next;
    }
    return gains;
}

double distortion_of_angle(double apex_deg) {
    const double height = 0.5 / std::tan(apex_deg * 0.008726646259971648);
    return (1.5 + 2 * height * height) / (2 * std::sqrt(3.0) * height);
}

int full_cells(const step::Lattice& lattice) {
    int count = 0;
    for (int row = 1; row + 1 < lattice.rows; ++row)
        for (int column = 1; column + 1 < lattice.columns; ++column)
            count += step::honeycomb_class(column, row) == 0;
    return count;
}

step::BalanceView balance_view(const som::LevelPlan& plan, const BalanceConfig& config, bool pinned) {
    step::BalanceView view{};
    view.lattice = plan.lattice;
    view.extent_x = plan.extent_x;
    view.extent_y = plan.extent_y;
    view.pinned = pinned;
    view.outline = plan.outline;
    view.slots = (plan.lattice.columns + 2) / 3;
    view.stride = view.slots + 2;
    const auto threshold = [&](double share) {
        return static_cast<float>(distortion_of_angle(share * config.least_angle_deg));
    };
    view.threshold = threshold(kFirstAngle);
    view.least_threshold = threshold(kLargestAngle);
    view.most_threshold = threshold(kSmallestAngle);
    const double sine = std::sin(config.least_angle_deg * 0.017453292519943295);
    view.thin_sine2 = static_cast<float>(sine * sine);
    view.width = plan.width;
    view.height = plan.height;
    return view;
}

int balance_iterations(const BalanceConfig& config, int level) {
    return level <= 1 ? config.iterations : 2 * config.iterations;
}

step::BalanceLimits balance_limits(const BalanceConfig& config, int level) {
    const int planned = balance_iterations(config, level);
    // the finest level never counts as stuck within the planned iterations, as its deviation
    // oscillates while it falls
    if (level == 0) return {planned, kMostOfPlanned * planned, 0.005f, 1e30f, true};
    return {planned, kMostOfPlanned * planned, 0.01f, 0.95f, false};
}

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
