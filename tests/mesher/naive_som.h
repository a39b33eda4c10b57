// The cellular self-organizing map by its definition, in plain loops: every neuron is compared with every
// point and every winner with every neuron, lattice distances come from walks over the lattice's edges, and
// sums are 64-bit. It shares nothing with the mesher except the configuration and the data.
#pragma once

#include "mesher/common/mesh_config.h"
#include "pipeline/data/density_map.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief::testing_mesher {

struct NaiveResult {
    HexMesh2D mesh;
    int levels = 0;
    long long draws = 0;       // points extracted in total
    long long lost_draws = 0;  // points that found no neuron within ssr
    int repair_sweeps = 0;     // sweeps that unfolded the lattice; 0 = nothing was folded
};

// Returns the result that the mesher's cellular method must give, bit for bit.
NaiveResult naive_som(const DensityMap& density, const MeshConfig& config);

// Returns the same for the sequential method, without the repair of folds.
HexMesh2D naive_sequential(const DensityMap& density, const MeshConfig& config);

}  // namespace hexrelief::testing_mesher
