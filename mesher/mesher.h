// Stage: density map -> hexagonal mesh, by the cellular self-organizing map (paper, sections 3 and 4).
#pragma once

#include <cstdint>
#include <vector>

#include "mesher/common/mesh_config.h"
#include "mesher/common/progress.h"
#include "pipeline/data/density_map.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief {

struct MeshResult {
    HexMesh2D mesh;
    int iterations = 0;  // parallel iterations, all levels (draws / cells for the sequential method)
    double device_training_s = 0;     // training alone on the device's own clock; 0 on the CPU
    double device_balance_s = 0;      // the same for balancing
    std::size_t device_bytes = 0;     // device memory in use at the peak; 0 on the CPU
    std::uint64_t map_on_device = 0;  // names the map's copy there, for DisparityMeshInput; 0 = none
};

// Runs the configured method on `threads` CPU threads (>= 1); the same bytes for any number of threads.
MeshResult solve_mesh(const DensityMap& density, const MeshConfig& config, int threads,
                      const ProgressFunction& progress);

}  // namespace hexrelief
