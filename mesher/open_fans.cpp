#include <algorithm>
#include <numeric>

#include "mesher/sheet_parts.h"

namespace hexrelief {

std::vector<std::uint32_t> open_fans(const SplitLattice& lattice, const TriangleSides& sides,
                                     std::vector<Triangle>& triangles, std::vector<std::uint32_t>& origins) {
    // corners joined across closed edges, by disjoint sets whose root is the first corner
    std::vector<std::uint32_t> parents(3 * lattice.triangles.size());
    std::iota(parents.begin(), parents.end(), std::uint32_t{0});
    const auto root = [&](std::uint32_t i) {
        while (parents[i] != i) i = parents[i] = parents[parents[i]];
        return i;
    };
    const auto corner_of = [&](std::uint32_t t, std::uint32_t vertex) {
        const Triangle& v = lattice.triangles[t];
        return 3 * t + (v[0] == vertex ? 0u : v[1] == vertex ? 1u : 2u);
    };
    for (std::uint32_t t = 0; t < lattice.triangles.size(); ++t) {
        if (!sides.kept[t]) continue;
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::int32_t n = lattice.neighbours[t][k];
            if (n <= static_cast<std::int32_t>(t) || !sides.kept[n] || sides.open[t][k]) continue;
            for (const std::uint32_t c : {k, (k + 1) % 3}) {
                const std::uint32_t a = root(3 * t + c), b = root(corner_of(static_cast<std::uint32_t>(n),
                                                                            lattice.triangles[t][c]));
                parents[std::max(a, b)] = std::min(a, b);
            }
        }
    }
    std::vector<std::pair<std::uint32_t, std::uint32_t>> fans;  // vertex, first corner
    for (std::uint32_t i = 0; i < parents.size(); ++i)
        if (sides.kept[i / 3] && root(i) == i) fans.emplace_back(lattice.triangles[i / 3][i % 3], i);
    std::sort(fans.begin(), fans.end());
    std::vector<std::uint32_t> number(parents.size()), olds;
    for (const auto& [vertex, first] : fans) {
        number[first] = static_cast<std::uint32_t>(olds.size());
        olds.push_back(vertex);
    }
    triangles.clear();
    origins.clear();
    for (std::uint32_t t = 0; t < lattice.triangles.size(); ++t) {
        if (!sides.kept[t]) continue;
        triangles.push_back({number[root(3 * t)], number[root(3 * t + 1)], number[root(3 * t + 2)]});
        origins.push_back(t);
    }
    return olds;
}

}  // namespace hexrelief
