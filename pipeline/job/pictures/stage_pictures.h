// The files of --save-stages: each stage's result as data and as a picture.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/data/calibration.h"
#include "pipeline/data/density_map.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/hex_mesh.h"
#include "pipeline/data/image.h"
#include "pipeline/data/surface_mesh.h"

namespace hexrelief::job {

// Returns a picture of about 1200 px on its longer side, seen from 20 degrees to the side and a little above;
// textured if `texture` is not null. Drawn by a small z-buffer rasteriser with 2 x 2 samples per pixel.
Image render_relief(const SurfaceMesh& mesh, const Image* texture);

// The results to draw. `left` and `texture` may be null, the others must be set; map, density and left have
// one size.
struct StageResults {
    const DisparityMap* map = nullptr;
    const DensityMap* density = nullptr;
    const HexMesh2D* mesh = nullptr;
    const SurfaceMesh* surface = nullptr;
    const Image* left = nullptr;
    const Image* texture = nullptr;  // of the surface
    const Calibration* camera = nullptr;
    std::uint64_t seed = 1;
    int threads = 1;
};

// Returns the names disparity.pfm disparity.png depth.exr density.pfm density.png samples.png mesh2d.obj
// mesh2d.png weights.png relief.png.
const std::vector<std::filesystem::path>& stage_file_names();

// Returns the bytes of the file of this name. Throws Error(output).
std::vector<std::uint8_t> encode_stage_file(const StageResults& results, const std::filesystem::path& name);

// Draws disparities by a perceptually ordered colour map from the least known one (dark blue) to the largest
// (yellow); unknown pixels are black.
Image disparity_picture(const DisparityMap& map);
// Draws the density in grey with gamma 1/2.2; the largest density is white.
Image density_picture(const DensityMap& density);
// Draws `count` points with the density's probability, as the paper's roulette wheel does. Returns none if
// the density is 0 everywhere.
std::vector<Vec2f> sample_points(const DensityMap& density, int count, std::uint64_t seed);
// Draws all lattice edges over the backdrop (1 or 3 channels); small backdrops are drawn twice as large.
Image mesh_picture(const HexMesh2D& mesh, const Image& backdrop);
// Returns an OBJ file: `v x y 0` for all lattice vertices, row-major, then the lattice's triangles.
std::string mesh_obj(const HexMesh2D& mesh);

}  // namespace hexrelief::job
