// Balancing: moves a lattice to equal honeycomb weights, keeping its triangles in shape.
#pragma once

#include "mesher/cellular_som.h"

namespace hexrelief {

// Below this many vertices one thread works alone: an iteration has some 30 barriers. With both cores half
// taken by other work, cones small took 0.063 s on one thread and 0.088 s on two, 900 x 750 px 0.29 s and
// 0.35 s.
inline constexpr std::size_t kLeastSharedVertices = 20000;

// Balances `positions` in place on the level's density (plan.width x plan.height) on the team's threads: the
// same result for any number. pinned: the lattice's border lies on the image's and slides along it. Unfolds
// the lattice first and last. Does nothing where the density is 0 everywhere or no cell has six neighbours.
void balance_level(const LevelPlan& plan, const BalanceConfig& config, bool pinned,
                   const std::vector<float>& density, Team& team, LatticePositions& positions);

}  // namespace hexrelief
