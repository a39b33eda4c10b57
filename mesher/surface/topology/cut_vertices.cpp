#include "mesher/surface/topology/cut_vertices.h"

#include <atomic>
#include <numeric>

namespace hexrelief {

LatticeFans fans_of(const SplitLattice& lattice, const TriangleLabels& labels) {
    return {lattice.triangles.data(), lattice.neighbours.data(), labels.open.data(), labels.kept.data()};
}

CutTriangles cut_vertices(const SplitLattice& lattice, const TriangleLabels& labels, ThreadPool& pool) {
    const std::size_t count = lattice.triangles.size();
    const LatticeFans view = fans_of(lattice, labels);
    // A fan is known by its first corner, from where that is written to all others, and nothing else ever.
    constexpr std::uint32_t kNone = 0xffffffffu;
    const std::size_t threads = static_cast<std::size_t>(pool.size());
    RawVector<std::uint32_t> firsts(3 * count);
    std::vector<std::uint32_t> kept(threads + 1, 0), fans(lattice.points.size() + 1, 0);  // of a vertex
    constexpr int kSeveral = -1;
    std::vector<int> finders(lattice.points.size(), 0);  // of a vertex's fans: a thread, from 1 on
    const auto first_of = [&](std::uint32_t corner) { return std::atomic_ref(firsts[corner]); };
    pool.run([&](int thread) {
        const std::size_t begin = pool.share(count, thread), last = pool.share(count, thread + 1);
        std::fill_n(firsts.data() + 3 * begin, 3 * (last - begin), kNone);
        pool.barrier();
        std::uint32_t own = 0;
        for (std::size_t t = begin; t < last; ++t) {
            if (!labels.kept[t]) continue;
            ++own;
            for (std::uint32_t k = 0; k < 3; ++k) {
                const step::Corner corner{static_cast<std::uint32_t>(t), k};
                if (first_of(corner.number()).load(std::memory_order_relaxed) != kNone) continue;
                bool first = true;  // unless one of an earlier thread's is
                if (thread > 0)
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
                const std::uint32_t v = lattice.triangles[t][k];
                std::atomic_ref(fans[v]).fetch_add(1, std::memory_order_relaxed);
                std::atomic_ref finder(finders[v]);
                if (int found = 0;
                    !finder.compare_exchange_strong(found, thread + 1, std::memory_order_relaxed) &&
                    found != thread + 1)
                    finder.store(kSeveral, std::memory_order_relaxed);
            }
        }
        kept[static_cast<std::size_t>(thread) + 1] = own;
    });
    std::partial_sum(kept.begin(), kept.end(), kept.begin());
    // new vertices by old ones, those of one by first corners
    std::vector<std::uint32_t> next(fans.size());
    std::exclusive_scan(fans.begin(), fans.end(), next.begin(), std::uint32_t{0});
    CutTriangles cut;
    cut.points.resize(next.back());
    RawVector<std::uint32_t> numbers(firsts.size());
    // first corners at vertices of which several threads found fans
    std::vector<std::vector<std::uint32_t>> shared(threads);
    const auto number = [&](std::uint32_t i, std::uint32_t v) {
        cut.points[next[v]] = lattice.points[v];
        numbers[i] = next[v]++;
    };
    cut.triangles.resize(kept.back());
    cut.source_triangles.resize(kept.back());
    pool.run([&](int thread) {
        const std::size_t begin = pool.share(count, thread), last = pool.share(count, thread + 1);
        for (std::size_t t = begin; t < last; ++t)
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t i = static_cast<std::uint32_t>(3 * t + k), v = lattice.triangles[t][k];
                if (!labels.kept[t] || firsts[i] != i) continue;
                if (finders[v] == kSeveral)
                    shared[static_cast<std::size_t>(thread)].push_back(i);
                else
                    number(i, v);
            }
        pool.barrier();
        if (thread == 0)
            for (const std::vector<std::uint32_t>& some : shared)
                for (const std::uint32_t i : some) number(i, lattice.triangles[i / 3][i % 3]);
        pool.barrier();
        std::size_t at = kept[static_cast<std::size_t>(thread)];
        for (std::size_t t = begin; t < last; ++t) {
            if (!labels.kept[t]) continue;
            for (std::size_t k = 0; k < 3; ++k) cut.triangles[at][k] = numbers[firsts[3 * t + k]];
            cut.source_triangles[at++] = static_cast<std::uint32_t>(t);
        }
    });
    return cut;
}

}  // namespace hexrelief
