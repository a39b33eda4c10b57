// The parallel cellular model on CPU threads (paper, section 4).
#pragma once

#include "mesher/common/progress_function.h"
#include "mesher/common/thread_pool.h"
#include "mesher/som/level_plan.h"

namespace hexrelief::som {

// Positions of one level's lattice, structure of arrays, in the level's px.
struct LatticePositions {
    std::vector<float> x, y;  // columns * rows
};

// Regular lattice of the level's size.
LatticePositions regular_positions(const LevelPlan& plan);

// Puts the lattice's border onto that of the plan's area (MeshBorder::fit, MeshBorder::slide).
void pin_border(const LevelPlan& plan, LatticePositions& positions);

// Trains `positions` in place on the level's density (plan.width x plan.height) on the pool's threads: the
// same result for any number. Does nothing where the density is 0 everywhere.
void train_level(const LevelPlan& plan, const MeshConfig& config, const std::vector<float>& density,
                 ThreadPool& pool, LatticePositions& positions, const ProgressFunction& progress);

// Repairs folded triangles in place; pinned: the lattice's border lies on the image's and stays there.
// held: one a vertex, not 0 where it may not move; null: all move. Returns the number of sweeps. What cannot
// be repaired in step::kMostUntangleSweeps stays and shows in the quality measures.
int untangle(const LevelPlan& plan, bool pinned, const std::uint8_t* held, ThreadPool& pool,
             LatticePositions& positions);

}  // namespace hexrelief::som
