#include <algorithm>

#include "mesher/sheet_parts.h"

namespace hexrelief {
namespace {

// Calls visit(t, k, n) for each edge once: from corner k of triangle t, to triangle n, or -1.
template <typename Visit>
void each_edge(const SplitLattice& lattice, const Visit& visit) {
    for (std::uint32_t t = 0; t < lattice.triangles.size(); ++t)
        for (int k = 0; k < 3; ++k) {
            const std::int32_t n = lattice.neighbours[t][k];
            if (n < 0 || n > static_cast<std::int32_t>(t)) visit(t, k, n);
        }
}

}  // namespace

// An edge's few pixel pairs err now and then, and one closed edge in a cut holds both surfaces together as
// far as the next vertices: left so, teddy at full size has 3.6 instead of 2.9 % of sheet.
void SideFinder::join_cuts(const SplitLattice& lattice) {
    std::vector<std::uint8_t> cuts(lattice.points.size(), 0);  // a vertex: edges of cuts at it, 2 = or more
    const auto kept = [&](std::int32_t t) { return t >= 0 && sides_.kept[t]; };
    const auto count = [&](std::uint32_t t, int k) {
        for (const std::uint32_t v : {lattice.triangles[t][k], lattice.triangles[t][(k + 1) % 3]})
            cuts[v] = static_cast<std::uint8_t>(std::min(cuts[v] + 1, 2));
    };
    each_edge(lattice, [&](std::uint32_t t, int k, std::int32_t n) {
        if (kept(static_cast<std::int32_t>(t)) != kept(n) || (sides_.kept[t] && sides_.open[t][k]))
            count(t, k);
    });
    const auto open_where = [&](const auto& is_part) {
        each_edge(lattice, [&](std::uint32_t t, int k, std::int32_t n) {
            if (!sides_.kept[t] || !kept(n) || sides_.open[t][k]) return;
            const int a = cuts[lattice.triangles[t][k]], b = cuts[lattice.triangles[t][(k + 1) % 3]];
            if (!is_part(a, b, t, static_cast<std::uint32_t>(n))) return;
            const auto& back = lattice.neighbours[n];
            const auto m = std::find(back.begin(), back.end(), static_cast<std::int32_t>(t)) - back.begin();
            sides_.open[t][k] = sides_.open[n][m] = 1;
            count(t, k);
        });
    };
    const auto joins = [](int a, int b, std::uint32_t, std::uint32_t) { return a == 1 && b == 1; };
    open_where(joins);
    open_where([&](int a, int b, std::uint32_t t, std::uint32_t n) { return a + b == 1 && differ(t, n); });
}

}  // namespace hexrelief
