// The paper's CPU counterpart: the online self-organizing map, which learns one point at a time (section 3).
#pragma once

#include "mesher/som/cellular_som.h"

namespace hexrelief::som {

// Trains the regular lattice and returns its positions. Makes t_max x cells draws from the cumulative
// distribution of the whole density (plan.width x plan.height; Eq. 5) and learns from each at once (Eq. 3).
// Learning rate and radius decrease after every `cells` draws; neurons are sorted into cells after every crr
// x cells draws (paper, section 6.4). config.delta is not used.
LatticePositions train_sequential(const std::vector<float>& density, const LevelPlan& plan,
                                  const MeshConfig& config, const ProgressFunction& progress);

}  // namespace hexrelief::som
