// Levels of the plain-loop self-organizing map: their sizes, densities and undeformed lattices, the way from
// one to the next, and the repair of folds.
#pragma once

#include <vector>

#include "mesher/common/mesh_config.h"
#include "pipeline/data/density_map.h"
#include "pipeline/data/geometry.h"

namespace hexrelief::testing_mesher {

struct Level {
    int number = 0, width = 0, height = 0;  // px of this level's density
    float extent_x = 0, extent_y = 0;       // of the image, in this level's px
    int columns = 0, rows = 0;
    std::vector<float> density;
    std::vector<Vec2f> neurons;
};

// Finest first, without densities and neurons.
std::vector<Level> make_levels(const DensityMap& density, const MeshConfig& config);

// Sampling weights: density^magnification through the mesher's documented table of 4,096 intervals.
std::vector<float> sampling_weights(const DensityMap& density, double magnification);

// The coarse level's density from the finer one's.
void halve(const Level& fine, Level& coarse);

void place_regularly(Level& level);
// Where the coarse level's lattice puts a vertex of the fine one.
Vec2f refined(const Level& coarse, const Level& fine, int column, int row, bool pinned);
// Puts a vertex of the lattice's border onto the image's.
void pin(const Level& level, int column, int row, Vec2f& p);

// Returns the number of sweeps; 0 = nothing was folded.
int unfold(Level& level, bool pinned);

}  // namespace hexrelief::testing_mesher
