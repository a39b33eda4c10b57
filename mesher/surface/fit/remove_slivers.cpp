#include "mesher/surface/fit/remove_slivers.h"

#include <algorithm>
#include <numeric>

#include "mesher/surface/fit/remove_slivers_step.h"

namespace hexrelief {

void remove_slivers(DisparityMesh& cut_mesh, double discontinuity_px, ThreadPool& pool) {
    std::vector<std::uint8_t> slivers(cut_mesh.triangles.size());
    std::vector<std::size_t> found(static_cast<std::size_t>(pool.size()), 0);
    pool.run([&](int thread) {
        std::size_t count = 0;
        for (std::size_t i = pool.share(slivers.size(), thread), end = pool.share(slivers.size(), thread + 1);
             i < end; ++i) {
            const auto& [a, b, c] = cut_mesh.triangles[i];
            slivers[i] = step::is_sliver(cut_mesh.points[a], cut_mesh.points[b], cut_mesh.points[c],
                                         cut_mesh.disparities[a], cut_mesh.disparities[b],
                                         cut_mesh.disparities[c], discontinuity_px);
            count += slivers[i];
        }
        found[static_cast<std::size_t>(thread)] = count;
    });
    if (std::accumulate(found.begin(), found.end(), std::size_t{0}) == 0) return;
    std::size_t kept = 0;
    std::vector<std::uint32_t> non_manifold;
    for (std::size_t i = 0; i < slivers.size(); ++i) {
        if (slivers[i])
            non_manifold.insert(non_manifold.end(), cut_mesh.triangles[i].begin(),
                                cut_mesh.triangles[i].end());
        else
            cut_mesh.triangles[kept++] = cut_mesh.triangles[i];
    }
    cut_mesh.triangles.resize(kept);
    constexpr std::uint32_t kUnused = 0xFFFFFFFFu;
    std::vector<std::uint32_t> place(cut_mesh.points.size(), kUnused);
    for (const Triangle& t : cut_mesh.triangles)
        for (const std::uint32_t v : t) place[v] = 0;
    std::uint32_t used = 0;
    for (std::size_t v = 0; v < place.size(); ++v) {
        if (place[v] == kUnused) continue;
        cut_mesh.points[used] = cut_mesh.points[v];
        cut_mesh.disparities[used] = cut_mesh.disparities[v];
        place[v] = used++;
    }
    cut_mesh.points.resize(used);
    cut_mesh.disparities.resize(used);
    for (Triangle& t : cut_mesh.triangles)
        for (std::uint32_t& v : t) v = place[v];
    std::sort(non_manifold.begin(), non_manifold.end());
    non_manifold.erase(std::unique(non_manifold.begin(), non_manifold.end()), non_manifold.end());
    std::erase_if(non_manifold, [&](std::uint32_t v) { return place[v] == kUnused; });
    for (std::uint32_t& v : non_manifold) v = place[v];
    cut_mesh.non_manifold = std::move(non_manifold);
}

}  // namespace hexrelief
