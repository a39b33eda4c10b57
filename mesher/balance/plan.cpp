#include "mesher/balance/plan.h"

#include <cmath>

namespace hexrelief::balance {
namespace {

// Largest number of iterations of a level that is far from balance, as a multiple of the planned number.
constexpr int kMostOfPlanned = 8;

// Angles below which triangles resist, as shares of the smallest angle wanted: start value and range.
constexpr double kFirstAngle = 0.89, kSmallestAngle = 0.815, kLargestAngle = 1.235;

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

}  // namespace hexrelief::balance
