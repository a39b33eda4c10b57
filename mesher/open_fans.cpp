#include <atomic>
#include <numeric>

#include "mesher/sheet_parts.h"
#include "mesher/steps/fans.h"

namespace hexrelief {

std::vector<std::uint32_t> open_fans(const SplitLattice& lattice, const TriangleSides& sides,
                                     std::vector<Triangle>& triangles, std::vector<std::uint32_t>& origins,
                                     Team& team) {
    const std::size_t count = lattice.triangles.size();
    const step::FanView view{lattice.triangles.data(), lattice.neighbours.data(), sides.open.data(),
                             sides.kept.data()};
    // A fan is known by its first corner, from where that is written to all others, and nothing else ever.
    constexpr std::uint32_t kNone = 0xffffffffu;
    RawVector<std::uint32_t> firsts(3 * count);
    std::vector<std::uint32_t> kept(team.size() + 1, 0);
    const auto first_of = [&](std::uint32_t corner) { return std::atomic_ref(firsts[corner]); };
    team.run([&](int thread) {
        const std::size_t begin = team.share(count, thread), last = team.share(count, thread + 1);
        std::fill(&firsts[3 * begin], &firsts[3 * begin] + 3 * (last - begin), kNone);
        team.barrier();
        for (std::size_t t = begin; t < last; ++t) {
            if (!sides.kept[t]) continue;
            ++kept[thread + 1];
            for (std::uint32_t k = 0; k < 3; ++k) {
                const step::Corner corner{static_cast<std::uint32_t>(t), k};
                if (first_of(corner.number()).load(std::memory_order_relaxed) != kNone) continue;
                bool first = true;  // unless one of another thread's is
                step::each_of_fan(view, corner, [&](const step::Corner& c) {
                    return first = c.number() > corner.number();
                });
                if (!first) continue;
                const auto write = [&](const step::Corner& c) {
                    first_of(c.number()).store(corner.number(), std::memory_order_relaxed);
                    return true;
                };
                write(corner);
                step::each_of_fan(view, corner, write);
            }
        }
    });
    std::partial_sum(kept.begin(), kept.end(), kept.begin());
    // new vertices by old ones, those of one by first corners
    const auto each_first = [&](const auto& visit) {
        for (std::uint32_t i = 0; i < firsts.size(); ++i)
            if (sides.kept[i / 3] && firsts[i] == i) visit(i, lattice.triangles[i / 3][i % 3]);
    };
    std::vector<std::uint32_t> next(lattice.points.size() + 1, 0);
    each_first([&](std::uint32_t, std::uint32_t vertex) { ++next[vertex + 1]; });
    std::partial_sum(next.begin(), next.end(), next.begin());
    std::vector<std::uint32_t> olds(next.back());
    RawVector<std::uint32_t> numbers(firsts.size());
    each_first([&](std::uint32_t i, std::uint32_t vertex) {
        olds[next[vertex]] = vertex;
        numbers[i] = next[vertex]++;
    });
    triangles.resize(kept.back());
    origins.resize(kept.back());
    team.run([&](int thread) {
        std::size_t at = kept[thread];
        const std::size_t last = team.share(count, thread + 1);
        for (std::size_t t = team.share(count, thread); t < last; ++t) {
            if (!sides.kept[t]) continue;
            for (std::size_t k = 0; k < 3; ++k) triangles[at][k] = numbers[firsts[3 * t + k]];
            origins[at++] = static_cast<std::uint32_t>(t);
        }
    });
    return olds;
}

}  // namespace hexrelief
