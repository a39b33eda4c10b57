// The mesher's manual. This header is enough to mesh a whole map. Three functions, on CPU threads:
//
// - solve_mesh: density map -> hexagonal mesh in the image (paper, sections 3 and 4);
// - measure_quality: hexagonal mesh and density map -> %cost and angles (section 2.2);
// - cut_disparity_mesh: hexagonal mesh and disparity map -> triangles with disparities, cut along depth
//   discontinuities (not in the paper).
//
// Parts of a map need balance_patch (mesher/balance/balance.h) and mesher/tiles as well.
//
// Their parameters, with units, ranges and defaults, are MeshConfig and SurfaceConfig. Configs are not
// checked against these ranges.
//
// Units: positions and lengths in px of the left image, where pixel (x, y) is the square from (x, y) to
// (x + 1, y + 1) and y points down; disparities in px; angles in degrees.
//
// Threads: a call works on as many threads as it is given (>= 1), of which the caller's is one. Calls share
// no state, so several may run at once.
//
// Determinism: the same input gives the same bytes for any number of threads, on every x86-64 CPU and on CUDA
// devices (cuda/cuda_mesher.h). All randomness comes from MeshConfig::seed.
//
// Errors: Error(usage) for parameters that do not fit the image, Error(input) for maps that do not fit each
// other.
#pragma once

#include <cstddef>
#include <cstdint>

#include "mesher/common/mesh_config.h"
#include "mesher/common/progress.h"
#include "mesher/common/surface_config.h"
#include "mesher/quality/quality.h"
#include "mesher/surface/disparity_mesh.h"
#include "pipeline/data/density_map.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief {

struct MeshResult {
    HexMesh2D mesh;
    int iterations = 0;  // parallel iterations of all levels; for the sequential method draws / cells
    // Of the CUDA backend, 0 on the CPU: seconds of training and of balancing on the device's own clock, the
    // largest amount of device memory in use, and the id of the disparity map that was left on the device,
    // for DisparityMeshInput::map_on_device (0 = none).
    double device_training_s = 0;
    double device_balance_s = 0;
    std::size_t device_bytes = 0;
    std::uint64_t map_on_device = 0;
};

// Trains a hexagonal lattice on the density by the cellular self-organizing map, coarse to fine
// (MeshMethod::cellular; paper, section 4), or by the online map (MeshMethod::sequential; section 3), and
// balances it (BalanceConfig). The mesh has max(3, round(size / spacing_px)) columns and rows and covers what
// MeshConfig::border says. Densities are >= 0 and finite; where all are 0, the lattice stays regular.
// progress, which may be empty, is called on the calling thread with the share done, 0..1; what it throws
// stops the call and is thrown on. Throws Error(usage) where the image is smaller than three spacings either
// way.
MeshResult solve_mesh(const DensityMap& density, const MeshConfig& config, int threads,
                      const ProgressFunction& progress);

}  // namespace hexrelief
