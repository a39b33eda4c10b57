#include "mesher/mesher.h"

#include <algorithm>
#include <utility>

#include "mesher/balance/balance.h"
#include "mesher/balance/plan.h"
#include "mesher/som/cellular_som.h"
#include "mesher/som/level_plan.h"
#include "mesher/som/untangle_step.h"

namespace hexrelief::mesher {
namespace {

// The sampling weights of the finest level: density^magnification.
std::vector<float> sampling_weights(std::vector<float> weights, const MeshConfig& config, ThreadPool& pool) {
    const std::vector<float> table = som::magnification_table(config.magnification);
    const float largest = *std::max_element(weights.begin(), weights.end());
    if (table.empty() || !(largest > 0)) return weights;
    pool.parallel_for_each(weights.size(), [&](std::size_t i) {
        weights[i] = step::magnify(weights[i] / largest, table.data(), som::kMagnificationSteps);
    });
    return weights;
}

// Returns the density of the next coarser level, in which each pixel is the sum of four.
std::vector<float> coarser_density(const std::vector<float>& fine, int width, int height, ThreadPool& pool) {
    const int w = (width + 1) / 2, h = (height + 1) / 2;
    std::vector<float> coarse(static_cast<std::size_t>(w) * h);
    pool.parallel_for_each(h, [&](int y) {
        for (int x = 0; x < w; ++x)
            coarse[static_cast<std::size_t>(y) * w + x] =
                step::coarser_pixel(fine.data(), width, height, x, y);
    });
    return coarse;
}

// The densities of all levels, finest first.
std::vector<std::vector<float>> density_pyramid(std::vector<float> finest,
                                                const std::vector<som::LevelPlan>& plans, ThreadPool& pool) {
    std::vector<std::vector<float>> pyramid{std::move(finest)};
    for (std::size_t i = 1; i < plans.size(); ++i) {
        const som::LevelPlan& finer = plans[plans.size() - i];
        pyramid.push_back(coarser_density(pyramid.back(), finer.width, finer.height, pool));
    }
    return pyramid;
}

// Interpolates the start positions of a level from the result of the next coarser one.
som::LatticePositions prolongate(const som::LatticePositions& coarse, const som::LevelPlan& from,
                                 const som::LevelPlan& to, bool pinned) {
    const step::Refinement refinement{from.lattice, to.lattice, pinned};
    som::LatticePositions fine;
    for (int row = 0; row < to.lattice.rows; ++row)
        for (int column = 0; column < to.lattice.columns; ++column) {
            fine.x.push_back(step::prolongate(coarse.x.data(), refinement, column, row, to.extent_x));
            fine.y.push_back(step::prolongate(coarse.y.data(), refinement, column, row, to.extent_y));
        }
    return fine;
}

som::LatticePositions train_coarse_to_fine(std::vector<float> density,
                                           const std::vector<som::LevelPlan>& plans, const MeshConfig& config,
                                           ThreadPool& pool, const ProgressFunction& progress) {
    const bool balanced = config.balance.enabled;
    std::vector<std::vector<float>> pyramid =
        density_pyramid(sampling_weights(density, config, pool), plans, pool);
    // balancing equalises the density itself, not the sampling weights
    std::vector<std::vector<float>> masses;
    if (balanced) masses = density_pyramid(std::move(density), plans, pool);
    const bool pinned = config.border != MeshBorder::free;
    som::LatticePositions positions;
    for (std::size_t i = 0; i < plans.size(); ++i) {
        positions =
            i == 0 ? som::regular_positions(plans[0]) : prolongate(positions, plans[i - 1], plans[i], pinned);
        if (i == 0 && balanced) balance::equalise_start(plans[0], masses.back(), positions);
        if (pinned) som::pin_border(plans[i], positions);
        // work quadruples from level to level, so the finest level takes about three quarters of the time
        const double before = i == 0 ? 0 : 1.0 / (1 << 2 * (plans.size() - i));
        const double after = 1.0 / (1 << 2 * (plans.size() - 1 - i));
        som::train_level(plans[i], config, pyramid.back(), pool, positions, [&](double share) {
            if (progress) progress(before + (after - before) * share);
        });
        pyramid.pop_back();
        if (!balanced) continue;
        balance::balance_level(plans[i], config.balance, pinned, nullptr, masses.back(), pool, positions);
        masses.pop_back();
    }
    som::untangle(plans.back(), pinned, nullptr, pool, positions);
    return positions;
}

// Trains by the online map. A free border can become so crumpled that som::untangle() does not unfold it;
// once pinned to the image's border, it always unfolds.
som::LatticePositions train_one_by_one(std::vector<float> density, const som::LevelPlan& plan,
                                       const MeshConfig& config, ThreadPool& pool,
                                       const ProgressFunction& progress) {
    som::LatticePositions positions =
        som::train_sequential(sampling_weights(std::move(density), config, pool), plan, config, progress);
    if (som::untangle(plan, false, nullptr, pool, positions) == step::kMostUntangleSweeps) {
        som::pin_border(plan, positions);
        som::untangle(plan, true, nullptr, pool, positions);
    }
    return positions;
}

HexMesh2D mesh_of(const som::LatticePositions& positions, const step::Lattice& lattice,
                  const som::MeshArea& area) {
    HexMesh2D mesh;
    mesh.columns = lattice.columns;
    mesh.rows = lattice.rows;
    for (std::size_t i = 0; i < positions.x.size(); ++i)
        mesh.positions.push_back(
            {static_cast<float>(area.x) + positions.x[i], static_cast<float>(area.y) + positions.y[i]});
    return mesh;
}

}  // namespace

HexMesh2D regular_mesh(int width, int height, const MeshConfig& config) {
    const som::MeshArea whole{0, 0, width, height};
    const som::LevelPlan plan = som::plan_levels(width, height, config, whole).back();
    som::LatticePositions positions = som::regular_positions(plan);
    som::pin_border(plan, positions);
    return mesh_of(positions, plan.lattice, whole);
}

HexMesh2D solve_mesh(const DensityMap& density, const MeshConfig& config, int threads,
                     const ProgressFunction& progress) {
    const som::MeshArea area = som::mesh_area(density, config);
    std::vector<som::LevelPlan> plans = som::plan_levels(density.width, density.height, config, area);
    const som::MeshOutline outline = som::mesh_outline(density, area, config);
    for (som::LevelPlan& plan : plans)
        plan.outline = som::outline_of(outline, outline.upper.data(), outline.lower.data(), plan.level);
    std::vector<float> values = som::density_within(density, area);
    ThreadPool pool(threads);
    const som::LatticePositions positions =
        config.method == MeshMethod::sequential
            ? train_one_by_one(std::move(values), plans.back(), config, pool, progress)
            : train_coarse_to_fine(std::move(values), plans, config, pool, progress);
    HexMesh2D mesh = mesh_of(positions, plans.back().lattice, area);
    for (const som::LevelPlan& plan : plans) mesh.iterations += static_cast<int>(plan.iterations.size());
    return mesh;
}

}  // namespace hexrelief::mesher
