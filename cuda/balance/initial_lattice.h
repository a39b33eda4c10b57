// First positions of a lattice that will be balanced, as balance::equalise_start does it.
#pragma once

#include "cuda/som/level.h"

namespace hexrelief::cuda {

// Entries of the sums below.
std::size_t start_sums(const som::LevelPlan& plan);

// Places the level's lattice (on the image's border where pinned) so that its columns, and its rows, hold
// equal masses of the density. largest: float bits of the densest pixel; sums: scratch.
void place_equalised(const Launch& launch, const LevelView& level, const som::LevelPlan& plan,
                     const float* density, const std::uint32_t* largest, std::int64_t* sums);

}  // namespace hexrelief::cuda
