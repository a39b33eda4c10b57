#include "mesher/surface/topology/cut_vertices.h"

#include <algorithm>
#include <atomic>
#include <numeric>
#include <utility>

namespace hexrelief::surface {
namespace {

// Numbers the fans on all threads, each on its share of the triangles. A fan is identified by its first
// corner, the one with the lowest number.
class VertexCutter {
  public:
    VertexCutter(const SplitLattice& lattice, const TriangleLabels& labels, ThreadPool& pool)
        : lattice_(lattice),
          kept_(labels.kept),
          view_(fans_of(lattice, labels)),
          pool_(pool),
          first_corners_(3 * lattice.triangles.size()),
          numbers_(first_corners_.size()),
          fan_counts_(lattice.points.size() + 1, 0),
          finders_(lattice.points.size(), kNobody),
          kept_before_(static_cast<std::size_t>(pool.size()) + 1, 0),
          shared_(static_cast<std::size_t>(pool.size())) {}

    CutTriangles run() {
        pool_.run([&](int thread) { find_fans(thread); });
        std::partial_sum(kept_before_.begin(), kept_before_.end(), kept_before_.begin());
        // new vertices are ordered by source vertex, those of one source vertex by their fans' first corners
        next_.resize(fan_counts_.size());
        std::exclusive_scan(fan_counts_.begin(), fan_counts_.end(), next_.begin(), std::uint32_t{0});
        cut_.points.resize(next_.back());
        cut_.triangles.resize(kept_before_.back());
        cut_.source_triangles.resize(kept_before_.back());
        pool_.run([&](int thread) {
            number_fans(thread);
            pool_.barrier();
            if (thread == 0)
                for (const std::vector<std::uint32_t>& corners : shared_)
                    for (const std::uint32_t i : corners) number(i);
            pool_.barrier();
            write_triangles(thread);
        });
        return std::move(cut_);
    }

  private:
    static constexpr std::uint32_t kNone = 0xffffffffu;
    static constexpr int kNobody = 0, kSeveral = -1;  // values in place of a thread, which are counted from 1

    // Calls visit(t) for the kept triangles of a thread's share.
    template <typename Visit>
    void each_kept(int thread, const Visit& visit) const {
        const std::size_t count = lattice_.triangles.size(), end = pool_.share(count, thread + 1);
        for (std::size_t t = pool_.share(count, thread); t < end; ++t)
            if (kept_[t]) visit(static_cast<std::uint32_t>(t));
    }
    // Threads that meet in a fan write the same value.
    auto first_corner(std::uint32_t corner) { return std::atomic_ref(first_corners_[corner]); }

    // Finds the fans whose first corner is in the thread's share.
    void find_fans(int thread) {
        const std::size_t count = lattice_.triangles.size(), begin = pool_.share(count, thread);
        std::fill_n(first_corners_.data() + 3 * begin, 3 * (pool_.share(count, thread + 1) - begin), kNone);
        pool_.barrier();
        std::uint32_t kept = 0;
        each_kept(thread, [&](std::uint32_t t) {
            ++kept;
            for (std::uint32_t k = 0; k < 3; ++k) {
                const step::Corner corner{t, k};
                if (first_corner(corner.number()).load(std::memory_order_relaxed) == kNone &&
                    (thread == 0 || is_first_of_fan(corner)))
                    begin_fan(corner, thread);
            }
        });
        kept_before_[static_cast<std::size_t>(thread) + 1] = kept;
    }
    // True if no corner of the fan has a lower number.
    bool is_first_of_fan(const step::Corner& corner) const {
        bool first = true;
        step::each_of_fan(view_, corner,
                          [&](const step::Corner& c) { return first = c.number() > corner.number(); });
        return first;
    }
    // Writes the fan's first corner to all its corners and counts the fan at its vertex.
    void begin_fan(const step::Corner& corner, int thread) {
        const auto write = [&](const step::Corner& c) {
            first_corner(c.number()).store(corner.number(), std::memory_order_relaxed);
            return true;
        };
        write(corner);
        step::each_of_fan(view_, corner, write);
        const std::uint32_t v = lattice_.triangles[corner.triangle][corner.k];
        std::atomic_ref(fan_counts_[v]).fetch_add(1, std::memory_order_relaxed);
        std::atomic_ref finder(finders_[v]);
        if (int found = kNobody;
            !finder.compare_exchange_strong(found, thread + 1, std::memory_order_relaxed) &&
            found != thread + 1)
            finder.store(kSeveral, std::memory_order_relaxed);
    }
    // Numbers the thread's fans. Those of vertices at which several threads found fans are left to the first
    // thread, which numbers them in order.
    void number_fans(int thread) {
        each_kept(thread, [&](std::uint32_t t) {
            for (std::uint32_t k = 0; k < 3; ++k) {
                const std::uint32_t i = 3 * t + k;
                if (first_corners_[i] != i) continue;
                if (finders_[lattice_.triangles[t][k]] == kSeveral)
                    shared_[static_cast<std::size_t>(thread)].push_back(i);
                else
                    number(i);
            }
        });
    }
    // Numbers the fan with this first corner.
    void number(std::uint32_t corner) {
        const std::uint32_t v = lattice_.triangles[corner / 3][corner % 3];
        cut_.points[next_[v]] = lattice_.points[v];
        numbers_[corner] = next_[v]++;
    }
    // Writes the thread's triangles with their new vertices.
    void write_triangles(int thread) {
        std::size_t at = kept_before_[static_cast<std::size_t>(thread)];
        each_kept(thread, [&](std::uint32_t t) {
            for (std::size_t k = 0; k < 3; ++k)
                cut_.triangles[at][k] = numbers_[first_corners_[std::size_t{3} * t + k]];
            cut_.source_triangles[at++] = t;
        });
    }

    const SplitLattice& lattice_;
    const RawVector<std::uint8_t>& kept_;
    LatticeFans view_;
    ThreadPool& pool_;
    RawVector<std::uint32_t> first_corners_;  // per corner: the first corner of its fan
    RawVector<std::uint32_t> numbers_;        // per first corner: the number of its new vertex
    std::vector<std::uint32_t> fan_counts_;   // per vertex
    std::vector<std::uint32_t> next_;         // per vertex: the number of its next copy
    std::vector<int> finders_;                // per vertex: the thread that found its fans
    // per thread: number of triangles that the preceding threads keep
    std::vector<std::uint32_t> kept_before_;
    std::vector<std::vector<std::uint32_t>> shared_;  // per thread: first corners left to the first thread
    CutTriangles cut_;
};

}  // namespace

LatticeFans fans_of(const SplitLattice& lattice, const TriangleLabels& labels) {
    return {lattice.triangles.data(), lattice.neighbours.data(), labels.open.data(), labels.kept.data()};
}

CutTriangles cut_vertices(const SplitLattice& lattice, const TriangleLabels& labels, ThreadPool& pool) {
    return VertexCutter(lattice, labels, pool).run();
}

}  // namespace hexrelief::surface
