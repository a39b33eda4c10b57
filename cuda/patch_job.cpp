#include "cuda/patch_job.h"

#include "cuda/balance/balance.h"
#include "cuda/som/untangle.h"
#include "mesher/som/untangle_step.h"

namespace hexrelief::cuda {

void balance_patch(const Launch& launch, Arena& arena, Staging& staging, const DensityMap& density,
                   const BalanceConfig& config, balance::LatticePatch& patch) {
    const std::size_t vertices = patch.mesh.positions.size();
    if (vertices == 0) return;
    const som::LevelPlan plan = balance::patch_plan(density, patch);

    arena.reset();
    LevelView view{};
    view.lattice = plan.lattice;
    view.extent_x = plan.extent_x;
    view.extent_y = plan.extent_y;
    view.x = arena.take<float>(2 * vertices);
    view.y = view.x + vertices;  // directly behind x, for a single transfer
    auto* const held = arena.take<std::uint8_t>(2 * vertices);
    std::uint8_t* const held_with_it = held + vertices;  // including the border
    float* const masses = arena.take<float>(density.values.size());
    const UntangleScratch scratch{arena.take<std::uint8_t>(vertices), arena.take<std::uint8_t>(vertices),
                                  arena.take<float>(vertices), arena.take<float>(vertices),
                                  arena.take<int>(step::kMostUntangleSweeps + 1)};
    BalanceBuffers buffers = take_balance_buffers(launch, arena, {plan});
    buffers.grid.view.held = held_with_it;

    std::vector<float> positions(2 * vertices);
    for (std::size_t i = 0; i < vertices; ++i) {
        positions[i] = patch.mesh.positions[i].x;
        positions[vertices + i] = patch.mesh.positions[i].y;
    }
    staging.upload(launch.stream, view.x, positions.data(), positions.size());
    staging.upload(launch.stream, held, patch.held.data(), vertices);
    staging.upload(launch.stream, held_with_it, balance::held_with_border(patch).data(), vertices);
    staging.upload(launch.stream, masses, density.values.data(), density.values.size());
    // The border may be folded against held vertices next to it, so it is untangled first; from
    // then on it stays.
    untangle(launch, view, scratch, held);
    integrate_rows(launch, buffers, plan, 0, masses);
    balance(launch, buffers, plan, 0, config, view);
    staging.download(launch.stream, positions.data(), view.x, positions.size());
    for (std::size_t i = 0; i < vertices; ++i)
        patch.mesh.positions[i] = {positions[i], positions[vertices + i]};
}

}  // namespace hexrelief::cuda
