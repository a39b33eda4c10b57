// tiles_quality PLAN: measures how well a plan's solved tiles are balanced and fit their map, compared with
// one undivided mesh. For maps that fit into memory, of up to 16,384 px a side.
#include <cstdio>
#include <exception>
#include <memory>
#include <thread>

#include "mesher/mesher.h"
#include "pipeline/stages/surface.h"
#include "pipeline/stages/surface_quality.h"
#include "pipeline/tiles/planned_map.h"
#include "pipeline/tiles/tile_files.h"
#include "pipeline/tiles/tile_plan.h"

namespace hexrelief::tiles {
namespace {

struct Balanced {
    HexMesh2D lattice;
    SurfaceMesh surface;  // image points, disparities, triangles
};

Balanced undivided(const TilePlan& plan, const DisparityMap& map, const DensityMap& density, int threads) {
    Balanced found;
    found.lattice = mesher::solve_mesh(density, plan.config.mesh, threads, {});
    const DisparityMesh cut = surface::cut_disparity_mesh({&found.lattice, &map, plan.density.background_px},
                                                          plan.config.surface, threads);
    found.surface = stages::build_surface(cut, plan.width, plan.height, plan.calibration,
                                          plan.config.surface.min_component);
    return found;
}

// Returns the blocks that the tiles were cut from, and the triangles of the tiles' files.
Balanced in_tiles(const TilePlan& plan, const mesh_tiles::DensityOfWindow& density, int threads) {
    const mesh_tiles::LatticeTiling tiling = plan.tiling();
    const mesh_tiles::MapRect whole{0, 0, plan.width, plan.height};
    const mesh_tiles::CoarseLattice coarse{read_lattice(coarse_file(plan)), plan.shrunk_by, plan.width,
                                           plan.height};
    const mesh_tiles::TileSolver solver(tiling, coarse, plan.config.mesh.balance, density, threads);
    Balanced found;
    found.lattice = {plan.columns, plan.rows, {}};
    found.lattice.positions.resize(static_cast<std::size_t>(plan.columns) * plan.rows);
    SurfaceMesh& surface = found.surface;
    for (const TileNumber& tile : tiles_of_level(plan, plan.finest_level())) {
        const int i = tile.i, j = tile.j;
        const auto seam = [](bool is_there, const std::filesystem::path& path) {
            return is_there ? std::make_unique<mesh_tiles::Seam>(read_seam(path)) : nullptr;
        };
        const auto above = seam(j > 0, row_seam_file(plan, j)),
                   below = seam(j + 1 < tiling.down(), row_seam_file(plan, j + 1)),
                   left = seam(i > 0, column_seam_file(plan, i, j)),
                   right = seam(i + 1 < tiling.across(), column_seam_file(plan, i + 1, j));
        const mesh_tiles::LatticeBlock block =
            solver.tile(i, j, {above.get(), below.get(), left.get(), right.get()});
        for (int row = block.first_row; row < block.end_row(); ++row)
            for (int column = block.first_column; column < block.end_column(); ++column)
                found.lattice.positions[found.lattice.index(column, row)] =
                    mesh_tiles::in_window(block.at(column, row), whole);
        const mesh_tiles::TileMesh mesh = read_tile(tile_file(plan, tile, ".mesh"));
        const auto first = static_cast<std::uint32_t>(surface.image_points.size());
        for (const mesh_tiles::TileCorner& corner : mesh.corners) {
            surface.image_points.push_back(mesh_tiles::in_window(corner.place, whole));
            surface.disparities.push_back(corner.disparity);
        }
        for (const Triangle& t : mesh.triangles)
            surface.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
    return found;
}

int compare(const std::filesystem::path& folder) {
    const int threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
    const TilePlan plan = read_plan(folder);
    const PlannedMap file(plan, false);
    const DisparityMap map = file.read({0, 0, plan.width, plan.height}, threads);
    const auto density_of = [&](const mesh_tiles::MapRect& window) {
        return stages::density_at_scale(file.read(window), plan.density, plan.config.density, threads);
    };
    const DensityMap density = job::density_of({0, 0, plan.width, plan.height});
    const auto tell = [&](const std::string& name, const Balanced& found) {
        const quality::MeshQuality balance = quality::measure_quality(found.lattice, density, threads);
        const stages::SurfaceQuality fit =
            stages::measure_surface_quality(found.surface, map, plan.density.background_px, threads);
        std::printf("%-10s %%cost %.3f, %lld inverted; duo %.4f px, left view %.4f px; %zu triangles\n",
                    name.c_str(), balance.percent_cost, balance.inverted_triangles, fit.duo_rmse_near_px,
                    fit.rmse_near_px, found.surface.triangles.size());
        std::fflush(stdout);
    };
    const mesh_tiles::LatticeTiling tiling = plan.tiling();
    tell(std::to_string(tiling.across()) + " x " + std::to_string(tiling.down()),
         in_tiles(plan, density_of, threads));
    tell("undivided", undivided(plan, map, density, threads));
    return 0;
}

}  // namespace
}  // namespace hexrelief::tiles

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fputs("usage: tiles_quality PLAN\n", stderr);
        return 2;
    }
    try {
        return compare(argv[1]);
    } catch (const std::exception& failure) {
        std::fprintf(stderr, "tiles_quality: %s\n", failure.what());
        return 1;
    }
}
