// The cellular self-organizing map by its definition, in plain loops: every neuron is compared with every
// point, every winner with every neuron, lattice distances come from a walk over the lattice's edges, sums
// are 64-bit. Nothing is shared with the mesher but its configuration and the data.
#pragma once

#include <vector>

#include "mesher/common/mesh_config.h"
#include "pipeline/data/density_map.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief::testing_mesher {

struct NaiveResult {
    HexMesh2D mesh;
    int levels = 0;
    long long draws = 0;       // points extracted in all
    long long lost_draws = 0;  // those that found no neuron within ssr
    int repair_sweeps = 0;     // that unfolded the lattice; 0 = nothing was folded
};

// What the mesher's cellular method must give, bit for bit.
NaiveResult naive_som(const DensityMap& density, const MeshConfig& config);

// The same for the sequential method, whose folds stay.
HexMesh2D naive_sequential(const DensityMap& density, const MeshConfig& config);

}  // namespace hexrelief::testing_mesher
