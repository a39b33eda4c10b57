// What the host works out once for a balanced level, for the CPU loop and for CUDA alike.
#pragma once

#include <vector>

#include "mesher/common/mesh_config.h"
#include "mesher/balance/convergence_step.h"
#include "mesher/som/level_plan.h"

namespace hexrelief {

struct SweepGain {
    float keep, gain;  // of the Chebyshev direction; keep is 0 for the first sweep
};

// Coefficients of `sweeps` Chebyshev sweeps for eigenvalues in [0.02, 1].
std::vector<SweepGain> chebyshev_gains(int sweeps);

// Mean-ratio distortion of an isosceles triangle with this angle at its apex (1 at 60 degrees).
double distortion_of_angle(double apex_deg);

// Cells with all six neighbours.
int full_cells(const step::Lattice& lattice);

// A view of the level with all that needs no array and no mass.
step::BalanceView balance_view(const LevelPlan& plan, const BalanceConfig& config, bool pinned);

// Newton iterations planned for a level: config.iterations on the finest and the next
// coarser, twice as many on all others.
int balance_iterations(const BalanceConfig& config, int level);

// With them, how many more a level may take while it is far from balance.
step::BalanceLimits balance_limits(const BalanceConfig& config, int level);

}  // namespace hexrelief
