// What a run of the mesh stage will do, worked out once on the host for both backends: levels, sizes, and the
// learning tables of each iteration.
#pragma once

#include <cstdint>
#include <vector>

#include "mesher/common/mesh_config.h"
#include "mesher/som/cell_matrix_step.h"
#include "mesher/som/level_transfer_step.h"
#include "mesher/som/outline_step.h"

namespace hexrelief::som {

// Learning rate and neighbourhood of one iteration (paper, Eq. 3 and 4), as tables over the lattice distance.
struct LearningTables {
    int radius = 0;                   // floor(sigma)
    std::vector<std::uint32_t> gain;  // radius + 1: h(d) in 1/1024
    std::vector<std::uint32_t>
        decay;  // radius + 1: -log2(1 - alpha h(d)) in 1/65536, at most step::kFullDecay
};

LearningTables learning_tables(double alpha, double sigma);

inline constexpr int kMostBatch = 20;  // iterations of a batch

// Iterations of each batch between two refreshes of the cells, which are crr iterations apart. share: how
// many of all refreshes come before this one, 0..1. The length grows geometrically from prr to prr_final, is
// at most kMostBatch, and makes the batches of one refresh about equally long.
int batch_length(const MeshConfig& config, double share);

// The part of the image that the lattice covers.
struct MeshArea {
    int x = 0, y = 0, width = 0, height = 0;  // px
};

struct LevelPlan {
    int level = 0;  // 0 = finest; the level's pixel is 2^level px wide
    int width = 0;  // of the level's density, its px
    int height = 0;
    float extent_x = 0;  // of the area in the level's px: its width / 2^level
    float extent_y = 0;
    step::Lattice lattice{};
    // Of the lattice's first and last row, in host memory; straight unless mesh_outline bends it.
    step::Outline outline;
    step::CellGrid cells{};
    int draws = 0;  // the largest number of points that a cell extracts in an iteration
    std::vector<LearningTables> iterations;
    // For each iteration the length of its batch, which is the same between two refreshes.
    std::vector<int> batches;
};

// What a level's lattice is pinned to.
inline step::Border border_of(const LevelPlan& plan) {
    return {plan.lattice, plan.outline, plan.extent_x, plan.extent_y};
}

// Coarsest level first. Throws Error(usage) where the image holds fewer than 3 spacings either way.
// The lattice's size follows from the image, width x height px; it is laid over the area.
std::vector<LevelPlan> plan_levels(int width, int height, const MeshConfig& config, const MeshArea& area);

// Lattice of the finest level: max(3, round(size / spacing)) each way.
step::Lattice lattice_size(double width, double height, double spacing_px);

inline constexpr int kMagnificationSteps = 4096;
// (i / steps)^exponent, steps + 1 entries; empty where exponent is 1.
std::vector<float> magnification_table(double exponent);

}  // namespace hexrelief::som
