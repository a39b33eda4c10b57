// The mesher's manual. This header is enough to mesh a whole map. Three functions run on CPU threads:
//
// - solve_mesh: density map -> hexagonal mesh in the image (paper, sections 3 and 4);
// - measure_quality: hexagonal mesh and density map -> %cost and angles (section 2.2);
// - cut_disparity_mesh: hexagonal mesh and disparity map -> triangles with disparities, cut along depth
//   discontinuities (not in the paper).
//
// MeshConfig and SurfaceConfig hold their parameters with units, ranges and defaults. The functions do not
// check the values against these ranges.
//
// Units: positions and lengths are in px of the left image, in which pixel (x, y) is the square from (x, y)
// to (x + 1, y + 1) and y points down; disparities are in px; angles are in degrees.
//
// Threads: a call uses the given number of threads (>= 1), which includes the calling thread. Calls share no
// state, so several may run at once.
//
// Determinism: the same input gives the same bytes for any number of threads, on x86-64, arm64 and CUDA
// devices (cuda/cuda_mesher.h). All randomness comes from MeshConfig::seed.
//
// Errors: Error(usage) if parameters do not fit the image, Error(input) if maps do not fit each other.
#pragma once

#include "mesher/common/mesh_config.h"
#include "mesher/common/surface_config.h"
#include "mesher/quality/quality.h"
#include "mesher/surface/cut_disparity_mesh.h"
#include "pipeline/data/density_map.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief::mesher {

// Trains a hexagonal lattice on the density with the cellular self-organizing map, coarse to fine
// (MeshMethod::cellular; paper, section 4), or with the online map (MeshMethod::sequential; section 3), and
// then balances it (BalanceConfig). The mesh has max(3, round(size / spacing_px)) columns and rows and covers
// the part of the image that MeshConfig::border selects. Densities must be finite and >= 0; if all are 0, the
// lattice stays regular. `progress` may be empty; it is called on the calling thread with the share done,
// 0..1, and an exception from it ends the call and is passed on. Throws Error(usage) if the image is narrower
// or lower than three spacings.
HexMesh2D solve_mesh(const DensityMap& density, const MeshConfig& config, int threads,
                     const ProgressFunction& progress);

// Returns the lattice before training, with the same columns and rows, over the whole image and with its
// border on the image's. Throws as solve_mesh() does.
HexMesh2D regular_mesh(int width, int height, const MeshConfig& config);

}  // namespace hexrelief::mesher
