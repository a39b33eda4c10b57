// Balances one level on the device, with the same result as balance::balance_level(), and places the lattice
// from which balancing starts.
#pragma once

#include "cuda/som/level.h"
#include "mesher/balance/cell_equations_step.h"
#include "mesher/balance/plan.h"

namespace hexrelief::cuda {

inline constexpr int kMostSweeps = 100;

// Counts of the blocks' requests for edge integrals, and of the helper blocks' completed measurements.
struct EdgeSignals {
    std::uint32_t requested, measured;
};

// The argument that a balancing kernel takes by value; the arrays live as long as the run.
struct BalanceJob {
    // blocks and clusters use its x, y and edges, and keep all other arrays in shared memory
    step::BalanceView view;
    const std::int64_t* masses;  // total mass, number of non-empty pixels
    EdgeSignals* signals;        // for blocks and clusters
    double floor;
    step::BalanceLimits limits;
    int sweeps, full_cells;
    balance::SweepGain gains[kMostSweeps];
    // For the grid only:
    step::CellEquation* equations;  // one per cell, `slots` per row
    float* directions;
    std::uint8_t *marks, *grown;  // one per vertex
    step::BalanceSums* sums;      // three, used in turn
    int* flags;                   // three, used in turn
};

// Totals of a level's density, and its signals.
struct BalanceTotals {
    std::int64_t masses[2];  // total mass, number of non-empty pixels
    EdgeSignals signals;
    std::uint32_t largest;  // bits of the largest density
};

// The arrays of balancing, allocated once for the largest level.
struct BalanceBuffers {
    double* primitive;
    BalanceTotals* totals;  // one per level
    BalanceJob grid;        // its view.held, on the device, may be set for a lattice with held vertices
};

// The thread-block clusters with which this device can balance: the number of blocks of the largest
// cluster of which at least two run at once, and how many of these run at once; 0 if the device has
// no clusters (before Hopper).
struct ClusterCapacity {
    int blocks, clusters;
};
ClusterCapacity cluster_capacity();

// Takes the memory for levels of these sizes; arrays of the grid only for levels that fit
// no block or cluster.
BalanceBuffers take_balance_buffers(const Launch& launch, Arena& arena,
                                    const std::vector<som::LevelPlan>& plans);

// Computes the row-wise integrals of the level's density and their total, for balance(). `index`
// is the level's index.
void integrate_rows(const Launch& launch, const BalanceBuffers& buffers, const som::LevelPlan& plan,
                    int index, const float* density);

// Moves level.x, level.y to equal weights; untangles the lattice before and after. The last call of
// integrate_rows() must have been for this level.
void balance(const Launch& launch, const BalanceBuffers& buffers, const som::LevelPlan& plan, int index,
             const BalanceConfig& config, const LevelView& level);

// Number of entries of the sums below.
std::size_t start_sums(const som::LevelPlan& plan);

// Does the same as balance::equalise_start(): places the level's lattice (with the border on the area's if it
// is pinned) so that its columns hold equal masses of the density, and so do its rows. largest: float bits of
// the densest pixel; sums: scratch memory.
void place_equalised(const Launch& launch, const LevelView& level, const som::LevelPlan& plan,
                     const float* density, const std::uint32_t* largest, std::int64_t* sums);

}  // namespace hexrelief::cuda
