// The plan of a mesh stage run, worked out once on the host for both backends: levels, sizes, the learning
// tables of each iteration, and the part of the image that the lattice covers, with its curved borders.
#pragma once

#include <cstdint>
#include <vector>

#include "mesher/common/mesh_config.h"
#include "mesher/som/cell_matrix_step.h"
#include "mesher/som/level_transfer_step.h"
#include "mesher/som/outline_step.h"
#include "pipeline/data/density_map.h"

namespace hexrelief::som {

// Learning rate and neighbourhood function of one iteration (paper, Eq. 3 and 4),
// tabulated by lattice distance.
struct LearningTables {
    int radius = 0;                   // floor(sigma)
    std::vector<std::uint32_t> gain;  // radius + 1 entries: h(d) in 1/1024
    // radius + 1 entries: -log2(1 - alpha h(d)) in 1/65536, at most step::kFullDecay
    std::vector<std::uint32_t> decay;
};

// Returns the tables for learning rate alpha, 0..1, and neighbourhood radius sigma in lattice steps.
LearningTables learning_tables(double alpha, double sigma);

inline constexpr int kMostBatch = 20;  // iterations

// Returns the number of iterations in each batch between two refreshes of the cells, which are crr iterations
// apart. `share`, 0..1, is the progress of the run at that refresh. The length grows geometrically from prr
// to prr_final, is at most kMostBatch, and makes the batches of one refresh about equally long.
int batch_length(const MeshConfig& config, double share);

// The part of the image that the lattice covers.
struct MeshArea {
    int x = 0, y = 0, width = 0, height = 0;  // px
};

struct LevelPlan {
    int level = 0;  // 0 = finest; the level's pixel is 2^level px wide
    int width = 0;  // width and height of the level's density, in its px
    int height = 0;
    float extent_x = 0;  // width and height of the area in the level's px: its px / 2^level
    float extent_y = 0;
    step::Lattice lattice{};
    // The curves that the first and last row are pinned to, in host memory; straight
    // unless mesh_outline() bends them.
    step::Outline outline;
    step::CellGrid cells{};
    int draws = 0;  // largest number of points that a cell extracts in an iteration
    std::vector<LearningTables> iterations;
    // The batch length at each iteration, constant between two refreshes.
    std::vector<int> batches;
};

// Returns the border that a level's lattice is pinned to.
inline step::Border border_of(const LevelPlan& plan) {
    return {plan.lattice, plan.outline, plan.extent_x, plan.extent_y};
}

// Returns the plans of all levels, coarsest first. The lattice's size follows from the image, width
// x height px; the lattice is laid over the area. Throws Error(usage) if the image is narrower or
// lower than three spacings.
std::vector<LevelPlan> plan_levels(int width, int height, const MeshConfig& config, const MeshArea& area);

// Returns the size of the finest level's lattice: max(3, round(size / spacing)) columns and rows.
step::Lattice lattice_size(double width, double height, double spacing_px);

inline constexpr int kMagnificationSteps = 4096;
// Returns (i / kMagnificationSteps)^exponent for i = 0 .. kMagnificationSteps; empty if exponent is 1.
std::vector<float> magnification_table(double exponent);

// For MeshBorder::fit returns the smallest rectangle around all density, grown until it has at least one
// pixel per vertex and the lattice's spacings in the two directions differ by at most the factor
// kMostStretch. For other borders, or if there is no density, returns the whole image.
MeshArea mesh_area(const DensityMap& density, const MeshConfig& config);

// Upper and lower border of the lattice as y in px from the area's upper side, at x = 0, 1, .. width of the
// area. Both are empty if the borders are straight.
struct MeshOutline {
    std::vector<float> upper, lower;
};

// For MeshBorder::fit with balancing, bends both borders towards the density above and below which the area
// is empty: by at most kMostBend of its height, no steeper than kMostOutlineSlope, and with a margin of two
// spacings around all density. A mesh without these empty parts needs no thin triangles to span them.
MeshOutline mesh_outline(const DensityMap& density, const MeshArea& area, const MeshConfig& config);

// Returns the outline scaled for a level. `upper` and `lower` are copies of its curves in the memory of that
// level's positions (host or device).
step::Outline outline_of(const MeshOutline& outline, const float* upper, const float* lower, int level);

// Returns the density within the area, row by row.
std::vector<float> density_within(const DensityMap& density, const MeshArea& area);

}  // namespace hexrelief::som
