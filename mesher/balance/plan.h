// The values that the host computes for a level before it is balanced, for both backends, and the start
// positions of the coarsest level.
#pragma once

#include <vector>

#include "mesher/balance/convergence_step.h"
#include "mesher/common/mesh_config.h"
#include "mesher/som/cellular_som.h"
#include "mesher/som/level_plan.h"

namespace hexrelief::balance {

struct SweepGain {
    // factors of the previous direction and of the preconditioned residual; keep is 0 for the first sweep
    float keep, gain;
};

// Returns the coefficients of `sweeps` Chebyshev sweeps for eigenvalues in [0.02, 1].
std::vector<SweepGain> chebyshev_gains(int sweeps);

// Returns the mean-ratio distortion of an isosceles triangle with this angle at its apex (1 at 60 degrees).
double distortion_of_angle(double apex_deg);

// Returns the number of honeycomb cells with six neighbours.
int full_cells(const step::Lattice& lattice);

// Returns a view of the level without its arrays and its units of mass (step::set_units()).
step::BalanceView balance_view(const som::LevelPlan& plan, const BalanceConfig& config, bool pinned);

// Returns the number of Newton iterations planned for a level: config.iterations for the finest and the next
// coarser, twice as many for all others.
int balance_iterations(const BalanceConfig& config, int level);

// Returns that number with the level's largest number of iterations and its conditions for ending earlier.
step::BalanceLimits balance_limits(const BalanceConfig& config, int level);

// Moves the regular lattice of the coarsest level so that its columns hold equal masses of the level's
// density, and so do its rows (initial_lattice_step.h). Does nothing if the density is 0 everywhere.
void equalise_start(const som::LevelPlan& plan, const std::vector<float>& density,
                    som::LatticePositions& positions);

}  // namespace hexrelief::balance
