// The paper's CPU counterpart: the online self-organizing map, one point after the other. The oracle of the
// parallel model.
#pragma once

#include "mesher/som/cellular_som.h"

namespace hexrelief {

// t_max x cells draws from one roulette wheel over the whole density (plan.width x plan.height; Eq. 5), each
// applied at once (Eq. 3). Learning rate and radius fall once in `cells` draws; neurons are sorted into cells
// every crr x cells draws (paper, section 6.4). delta has no part in it.
LatticePositions train_sequential(const std::vector<float>& density, const LevelPlan& plan,
                                  const MeshConfig& config, const ProgressFunction& progress);

}  // namespace hexrelief
