// Start positions of a lattice that will be balanced.
#pragma once

#include <vector>

#include "mesher/som/cellular_som.h"

namespace hexrelief::balance {

// Moves the regular lattice of the coarsest level so that its columns hold equal masses of the level's
// density, and so do its rows (initial_lattice_step.h). Does nothing if the density is 0 everywhere.
void equalise_start(const som::LevelPlan& plan, const std::vector<float>& density,
                    som::LatticePositions& positions);

}  // namespace hexrelief::balance
