#include "pipeline/tiles/tile_jobs.h"

#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <mutex>

#include "mesher/common/thread_pool.h"

namespace hexrelief {

TileWorkers workers_of(const Backend& backend, int threads) {
    if (backend.name == "cpu") return {threads, balance_patch, cut_disparity_mesh};
    const auto turn = std::make_shared<std::mutex>();
    return {
        threads,
        [backend, turn](const DensityMap& density, const BalanceConfig& config, int, LatticePatch& patch) {
            const std::lock_guard lock(*turn);
            backend.balance_patch(density, config, patch);
        },
        [backend, turn](const DisparityMeshInput& input, const SurfaceConfig& config, int) {
            const std::lock_guard lock(*turn);
            return backend.cut_disparity_mesh(input, config).cut_mesh;
        }};
}

void keep_freed_memory() {
    mallopt(M_MMAP_THRESHOLD, 1 << 28);
    mallopt(M_TRIM_THRESHOLD, 1 << 28);
}

void do_jobs(std::size_t count, int jobs, const std::function<void(std::size_t)>& work) {
    ThreadPool pool(
        static_cast<int>(std::clamp<std::size_t>(count, 1, static_cast<std::size_t>(std::max(1, jobs)))));
    std::atomic<std::size_t> next{0};
    pool.run([&](int) {
        for (std::size_t k = next++; k < count; k = next++) work(k);
    });
}

}  // namespace hexrelief
