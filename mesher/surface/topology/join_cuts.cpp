#include <algorithm>
#include <atomic>
#include <cstdint>
#include <vector>

#include "mesher/surface/topology/label_triangles.h"

namespace hexrelief::surface {
namespace {

// The edge from corner k of triangle t to the next corner.
struct ClosedEdge {
    std::uint32_t t;
    int k;
};

}  // namespace

// Opens the closed edges between the ends of two cuts. The few pixel pairs of an edge err now and then, and
// one closed edge in a cut holds both surfaces together as far as the next vertices: without this step teddy
// at full size has 3.6 instead of 2.9 % of rubber sheet (triangles across a discontinuity). Edges are opened
// one after the other, because each changes the condition for the next. All threads collect the candidates
// first, which is safe because the number of cut edges at a vertex never falls.
void TriangleLabeler::join_cuts(const SplitLattice& lattice) {
    // Per vertex the number of cut edges at it; 2 stands for 2 or more.
    std::vector<std::uint8_t> cuts(lattice.points.size(), 0);
    // Candidates, edges between the ends of two cuts, that each thread finds in its share of
    // the triangles, in order.
    std::vector<std::vector<ClosedEdge>> found(static_cast<std::size_t>(pool_.size()));
    const auto kept = [&](std::int32_t t) { return t >= 0 && labels_.kept[t]; };
    const auto ends = [&](std::uint32_t t, int k) {
        return std::pair(lattice.triangles[t][k], lattice.triangles[t][(k + 1) % 3]);
    };
    pool_.run([&](int thread) {
        // Calls visit(t, k, n) for each edge once: from corner k of triangle t, with triangle n
        // across it, or -1.
        const auto each_edge = [&](const auto& visit) {
            const std::size_t end = pool_.share(lattice.triangles.size(), thread + 1);
            for (std::size_t t = pool_.share(lattice.triangles.size(), thread); t < end; ++t)
                for (int k = 0; k < 3; ++k) {
                    const std::int32_t n = lattice.neighbours[t][k];
                    if (n < 0 || n > static_cast<std::int32_t>(t)) visit(static_cast<std::uint32_t>(t), k, n);
                }
        };
        each_edge([&](std::uint32_t t, int k, std::int32_t n) {
            if (kept(static_cast<std::int32_t>(t)) == kept(n) && !(labels_.kept[t] && labels_.open[t][k]))
                return;
            const auto [a, b] = ends(t, k);
            for (const std::uint32_t v : {a, b})
                if (std::atomic_ref count(cuts[v]); count.load(std::memory_order_relaxed) < 2)
                    count.fetch_add(1, std::memory_order_relaxed);  // counts above 2 mean the same as 2
        });
        pool_.barrier();
        each_edge([&](std::uint32_t t, int k, std::int32_t n) {
            if (!labels_.kept[t] || !kept(n) || labels_.open[t][k]) return;
            const auto [a, b] = ends(t, k);
            if (cuts[a] == 1 && cuts[b] == 1) found[thread].push_back({t, k});
        });
    });
    for (const std::vector<ClosedEdge>& own : found)
        for (const auto& [t, k] : own) {
            const auto [a, b] = ends(t, k);
            if (cuts[a] != 1 || cuts[b] != 1) continue;
            const std::uint32_t n = static_cast<std::uint32_t>(lattice.neighbours[t][k]);
            const auto& back = lattice.neighbours[n];
            const auto m = std::find(back.begin(), back.end(), static_cast<std::int32_t>(t)) - back.begin();
            labels_.open[t][k] = labels_.open[n][m] = 1;
            cuts[a] = cuts[b] = 2;
        }
}

}  // namespace hexrelief::surface
