// Balancing of one level on the device, as hexrelief::balance_level does it.
#pragma once

#include "cuda/som/level.h"
#include "mesher/balance/cell_equations_step.h"
#include "mesher/balance/plan.h"

namespace hexrelief::cuda {

inline constexpr int kMostSweeps = 100;

// How often a group's blocks have asked for the masses of edges, and blocks beside it have measured them.
struct EdgeBoard {
    std::uint32_t asked, measured;
};

// What a balancing kernel takes by value; array contents live as long as the run.
struct BalanceJob {
    step::BalanceView view;  // x, y: of the level; but for these and edges, blocks and clusters use windows
    const std::int64_t* masses;  // total, number of pixels that are not empty
    EdgeBoard* board;            // of blocks and clusters
    double floor;
    step::BalanceLimits limits;
    int sweeps, full_cells;
    SweepGain gains[kMostSweeps];
    // the grid's alone
    step::CellEquation* equations;  // one a cell of `slots` a row
    float* directions;
    std::uint8_t *marks, *grown;  // one a vertex
    step::BalanceSums* sums;      // three, used in turn
    int* flags;                   // three, used in turn
};

struct BalanceTotals {
    std::int64_t masses[2];  // total, number of pixels that are not empty
    EdgeBoard board;
    std::uint32_t largest;  // density, its bits
};

// Most arrays of all levels, taken once for the largest.
struct BalanceBuffers {
    double* primitive;
    BalanceTotals* totals;  // one a level
    BalanceJob grid;
};

// Thread-block clusters that balance on this device: blocks of the largest of which at least two run at once,
// and how many do; 0 where there are none (before Hopper).
struct ClusterRoom {
    int blocks, clusters;
};
ClusterRoom balance_clusters();

// Takes the memory for levels of these sizes; grid arrays only for levels that no cluster holds.
BalanceBuffers take_balance_buffers(const Launch& launch, Arena& arena, const std::vector<LevelPlan>& plans);

// Row-wise integrals of the level's density, with their total, for balance(); `index` counts levels.
void integrate_rows(const Launch& launch, const BalanceBuffers& buffers, const LevelPlan& plan, int index,
                    const float* density);

// Moves level.x, level.y to equal weights, unfolding first and last. integrate_rows must have run on it last.
void balance(const Launch& launch, const BalanceBuffers& buffers, const LevelPlan& plan, int index,
             const BalanceConfig& config, const LevelView& level);

}  // namespace hexrelief::cuda
