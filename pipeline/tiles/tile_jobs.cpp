#include "pipeline/tiles/tile_jobs.h"

#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <set>

#include "pipeline/base/thread_pool.h"

namespace hexrelief::tiles {
namespace {

int pool_size(std::size_t count, int jobs) {
    return static_cast<int>(std::clamp<std::size_t>(count, 1, static_cast<std::size_t>(std::max(1, jobs))));
}

}  // namespace

TileWorkers workers_of(job::Backend& backend, int threads) {
    if (backend.name() == "cpu") return {threads, balance::balance_patch, surface::cut_disparity_mesh};
    const auto turn = std::make_shared<std::mutex>();
    return {threads,
            [&backend, turn](const DensityMap& density, const BalanceConfig& config, int,
                             balance::LatticePatch& patch) {
                const std::lock_guard lock(*turn);
                backend.balance_patch(density, config, patch);
            },
            [&backend, turn](const surface::DisparityMeshInput& input, const SurfaceConfig& config, int) {
                const std::lock_guard lock(*turn);
                return backend.cut_disparity_mesh(input, config);
            }};
}

void keep_freed_memory() {
    mallopt(M_ARENA_MAX, 1);  // other arenas hold 64 MiB, in which a window leaves no room for the next
    mallopt(M_MMAP_THRESHOLD, 1 << 28);
    mallopt(M_TRIM_THRESHOLD, 1 << 30);
    mallopt(M_TOP_PAD, 1 << 26);
}

void do_jobs(std::size_t count, int jobs, const std::function<void(std::size_t)>& work) {
    ThreadPool pool(pool_size(count, jobs));
    std::atomic<std::size_t> next{0};
    pool.run([&](int) {
        for (std::size_t k = next++; k < count; k = next++) work(k);
    });
}

void do_jobs_in_turn(const std::vector<std::size_t>& needed_by, int jobs,
                     const std::function<void(std::size_t)>& work) {
    const std::size_t count = needed_by.size();
    std::vector<std::size_t> waits_for(count);
    for (const std::size_t other : needed_by)
        if (other != kNeededByNone) ++waits_for[other];
    std::set<std::size_t> ready;
    for (std::size_t k = 0; k < count; ++k)
        if (waits_for[k] == 0) ready.insert(ready.end(), k);
    std::mutex turn;
    std::condition_variable changed;
    std::size_t not_begun = count;
    ThreadPool(pool_size(count, jobs)).run([&](int) {
        std::unique_lock lock(turn);
        while (not_begun > 0) {
            if (ready.empty()) {
                changed.wait(lock);
                continue;
            }
            const std::size_t k = *ready.begin();
            ready.erase(ready.begin());
            --not_begun;
            lock.unlock();
            try {
                work(k);
            } catch (...) {
                lock.lock();
                not_begun = 0;
                changed.notify_all();
                throw;
            }
            lock.lock();
            if (needed_by[k] != kNeededByNone && --waits_for[needed_by[k]] == 0) ready.insert(needed_by[k]);
            changed.notify_all();
        }
    });
}

}  // namespace hexrelief::tiles
