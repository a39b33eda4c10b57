// Start positions of a lattice that will be balanced, the same as balance::equalise_start()'s.
#pragma once

#include "cuda/som/level.h"

namespace hexrelief::cuda {

// Number of entries of the sums below.
std::size_t start_sums(const som::LevelPlan& plan);

// Places the level's lattice (with the border on the area's if it is pinned) so that its columns hold equal
// masses of the density, and so do its rows. largest: float bits of the densest pixel; sums: scratch memory.
void place_equalised(const Launch& launch, const LevelView& level, const som::LevelPlan& plan,
                     const float* density, const std::uint32_t* largest, std::int64_t* sums);

}  // namespace hexrelief::cuda
