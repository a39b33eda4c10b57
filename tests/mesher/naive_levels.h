// Levels of the plain-loop self-organizing map: their sizes, densities and undeformed lattices, the
// interpolation from one level to the next, and the repair of folds.
#pragma once

#include <vector>

#include "mesher/common/mesh_config.h"
#include "pipeline/data/density_map.h"
#include "pipeline/data/geometry.h"

namespace hexrelief::testing_mesher {

struct Level {
    int number = 0, width = 0, height = 0;  // px of this level's density
    float extent_x = 0, extent_y = 0;       // of the image, in px of this level
    int columns = 0, rows = 0;
    std::vector<float> density;
    std::vector<Vec2f> neurons;
};

// Returns the levels, finest first, without densities and neurons.
std::vector<Level> make_levels(const DensityMap& density, const MeshConfig& config);

// Returns the sampling weights: density^magnification by the mesher's documented table of 4,096 intervals.
std::vector<float> sampling_weights(const DensityMap& density, double magnification);

// Sets the coarse level's density from the finer one's.
void halve(const Level& fine, Level& coarse);

void place_regularly(Level& level);
// Returns the position that the coarse level's lattice gives to a vertex of the fine one.
Vec2f refined(const Level& coarse, const Level& fine, int column, int row, bool pinned);
// Moves a vertex of the lattice's border onto the image's border.
void pin(const Level& level, int column, int row, Vec2f& p);

// Repairs folds and returns the number of sweeps; 0 = nothing was folded.
int unfold(Level& level, bool pinned);

}  // namespace hexrelief::testing_mesher
