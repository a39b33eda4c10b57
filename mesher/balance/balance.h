// Balancing: moves the vertices so that all honeycomb cells get equal weights (paper, Eq. 1 and 2) and the
// triangles are well shaped.
#pragma once

#include <cstdint>
#include <vector>

#include "mesher/som/cellular_som.h"
#include "pipeline/data/density_map.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief::balance {

// Least number of vertices of a lattice that several threads share. Smaller ones are balanced by one
// thread, because an iteration has some 30 barriers. Seconds of the mesh stage on aloe, small / full
// size, with limits of 20,000, 4,000, 1,000 vertices: two threads 0.025, 0.018, 0.019 / 0.149, 0.156,
// 0.153; eight 0.025, 0.016, 0.011 / 0.104, 0.082, 0.072; sixteen 0.023, 0.013, 0.009 / 0.095, 0.075,
// 0.065 (sixteen idle cores).
inline constexpr std::size_t kLeastSharedVertices = 1000;

// Balances `positions` in place on the level's density (plan.width x plan.height values). The result does not
// depend on the number of threads. If `pinned`, the lattice's border lies on the area's and slides along it.
// `held` is as for untangle(). Untangles the lattice before and after. Does nothing if the density is 0
// everywhere or no cell has six neighbours.
void balance_level(const som::LevelPlan& plan, const BalanceConfig& config, bool pinned,
                   const std::uint8_t* held, const std::vector<float>& density, ThreadPool& pool,
                   som::LatticePositions& positions);

// A part of a lattice whose first vertex is the centre of a honeycomb cell of the whole lattice: its column
// in the whole lattice is a multiple of 3 and its row a multiple of 2.
struct LatticePatch {
    HexMesh2D mesh;                  // in px of the density that the patch lies on
    std::vector<std::uint8_t> held;  // one per vertex; nonzero = the vertex stays
};

// Returns the plan by which both backends balance a patch.
som::LevelPlan patch_plan(const DensityMap& density, const LatticePatch& patch);
// Returns patch.held with the vertices of the patch's border added.
std::vector<std::uint8_t> held_with_border(const LatticePatch& patch);

// Balances a patch on its part of the density, which must cover it. The vertices of its border stay in place.
void balance_patch(const DensityMap& density, const BalanceConfig& config, int threads, LatticePatch& patch);

}  // namespace hexrelief::balance
