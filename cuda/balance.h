// Balancing of one level on the device, as hexrelief::balance_level does it.
#pragma once

#include "cuda/level.h"
#include "mesher/steps/balance_cells.h"
#include "mesher/steps/balance_plan.h"

namespace hexrelief::cuda {

inline constexpr int kMostSweeps = 100;

// What a balancing kernel takes by value; array contents live as long as the run.
struct BalanceJob {
    step::BalanceView view;  // x, y: of the level; the rest: the grid's arrays, unused by blocks and clusters
    const std::int64_t* masses;  // total, number of pixels that are not empty
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

// Most arrays of all levels, taken once for the largest.
struct BalanceBuffers {
    double* primitive;
    std::int64_t* masses;    // two a level
    std::uint32_t* largest;  // one a level
    BalanceJob grid;
};

// Blocks of the largest cluster that balances on this device, 0 where it has none (before Hopper).
int balance_cluster_blocks();

// Takes the memory for levels of these sizes; grid arrays only for levels that no cluster holds.
BalanceBuffers take_balance_buffers(const Launch& launch, Arena& arena, const std::vector<LevelPlan>& plans);

// Row-wise integrals of the level's density, with their total, for balance(); `index` counts levels.
void integrate_rows(const Launch& launch, const BalanceBuffers& buffers, const LevelPlan& plan, int index,
                    const float* density);

// Moves level.x, level.y to equal weights, unfolding first and last. integrate_rows must have run on it last.
void balance(const Launch& launch, const BalanceBuffers& buffers, const LevelPlan& plan, int index,
             const BalanceConfig& config, const LevelView& level);

}  // namespace hexrelief::cuda
