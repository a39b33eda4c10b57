// Balancing of one level on the device, as balance::balance_level does it.
#pragma once

#include "cuda/som/level.h"
#include "mesher/balance/cell_equations_step.h"
#include "mesher/balance/plan.h"

namespace hexrelief::cuda {

inline constexpr int kMostSweeps = 100;

// How many times blocks have requested the masses of edges, and helper blocks have finished measuring them.
struct EdgeSignals {
    std::uint32_t requested, measured;
};

// What a balancing kernel takes by value; array contents live as long as the run.
struct BalanceJob {
    step::BalanceView view;  // blocks and clusters use its x, y and edges, and hold all else in shared memory
    const std::int64_t* masses;  // total, number of pixels that are not empty
    EdgeSignals* signals;        // for blocks and clusters
    double floor;
    step::BalanceLimits limits;
    int sweeps, full_cells;
    balance::SweepGain gains[kMostSweeps];
    // for the grid only
    step::CellEquation* equations;  // one a cell of `slots` a row
    float* directions;
    std::uint8_t *marks, *grown;  // one a vertex
    step::BalanceSums* sums;      // three, used alternately
    int* flags;                   // three, used alternately
};

struct BalanceTotals {
    std::int64_t masses[2];  // total, number of pixels that are not empty
    EdgeSignals signals;
    std::uint32_t largest;  // density, its bits
};

// Arrays of balancing, taken once for the largest level.
struct BalanceBuffers {
    double* primitive;
    BalanceTotals* totals;  // one a level
    BalanceJob grid;        // its view.held, on the device, may be set for a lattice of which vertices stay
};

// Thread-block clusters that balance on this device: the blocks of the largest cluster of which at least two
// run at once, and how many of these do; 0 where the device has no clusters (before Hopper).
struct ClusterCapacity {
    int blocks, clusters;
};
ClusterCapacity cluster_capacity();

// Takes the memory for levels of these sizes; grid arrays only for levels that no cluster holds.
BalanceBuffers take_balance_buffers(const Launch& launch, Arena& arena,
                                    const std::vector<som::LevelPlan>& plans);

// Row-wise integrals of the level's density, with their total, for balance(); `index` counts levels.
void integrate_rows(const Launch& launch, const BalanceBuffers& buffers, const som::LevelPlan& plan,
                    int index, const float* density);

// Moves level.x, level.y to equal weights; untangles the lattice before and after. The last call of
// integrate_rows must have been for this level.
void balance(const Launch& launch, const BalanceBuffers& buffers, const som::LevelPlan& plan, int index,
             const BalanceConfig& config, const LevelView& level);

}  // namespace hexrelief::cuda
