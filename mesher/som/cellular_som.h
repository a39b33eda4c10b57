// The self-organizing map on CPU threads: the paper's parallel cellular one (section 4), and the online one
// (section 3).
#pragma once

#include "mesher/common/mesh_config.h"
#include "mesher/som/level_plan.h"
#include "pipeline/base/thread_pool.h"

namespace hexrelief::som {

// Vertex positions of one level's lattice in the level's px, as a structure of arrays.
struct LatticePositions {
    std::vector<float> x, y;  // columns * rows values each
};

// Returns the undeformed lattice of the level's size.
LatticePositions regular_positions(const LevelPlan& plan);

// Moves the lattice's border onto the border of the plan's area (MeshBorder::fit, MeshBorder::slide).
void pin_border(const LevelPlan& plan, LatticePositions& positions);

// Trains `positions` in place on the level's density (plan.width x plan.height values). The result does not
// depend on the number of threads. Does nothing if the density is 0 everywhere.
void train_level(const LevelPlan& plan, const MeshConfig& config, const std::vector<float>& density,
                 ThreadPool& pool, LatticePositions& positions, const ProgressFunction& progress);

// Repairs folded triangles in place. If `pinned`, the lattice's border lies on the area's and stays on it.
// `held` has one value per vertex, nonzero if the vertex may not move; null: all may. Returns the number of
// sweeps. Folds left after step::kMostUntangleSweeps remain and show in the quality measures.
int untangle(const LevelPlan& plan, bool pinned, const std::uint8_t* held, ThreadPool& pool,
             LatticePositions& positions);

// The paper's CPU counterpart: the online self-organizing map, which learns one point at a time (section 3).
// Trains the regular lattice and returns its positions. Makes t_max x cells draws from the cumulative
// distribution of the whole density (plan.width x plan.height; Eq. 5) and learns from each at once (Eq. 3).
// Learning rate and radius decrease after every `cells` draws; neurons are sorted into cells after every crr
// x cells draws (paper, section 6.4). config.delta is not used.
LatticePositions train_sequential(const std::vector<float>& density, const LevelPlan& plan,
                                  const MeshConfig& config, const ProgressFunction& progress);

}  // namespace hexrelief::som
