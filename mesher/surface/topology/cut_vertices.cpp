#include "mesher/surface/topology/cut_vertices.h"

#include <algorithm>
#include <atomic>
#include <numeric>
#include <utility>

namespace hexrelief::surface {
namespace {

// Each thread has its share of the triangles. A fan is known by its first corner, the one with the lowest
// number.
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
        // new vertices by old ones, those of one by first corners
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
    static constexpr int kNobody = 0, kSeveral = -1;  // in place of a thread, counted from 1 on

    template <typename Visit>
    void each_kept(int thread, const Visit& visit) const {
        const std::size_t count = lattice_.triangles.size(), end = pool_.share(count, thread + 1);
        for (std::size_t t = pool_.share(count, thread); t < end; ++t)
            if (kept_[t]) visit(static_cast<std::uint32_t>(t));
    }
    // Threads that meet in a fan write the same.
    auto first_corner(std::uint32_t corner) { return std::atomic_ref(first_corners_[corner]); }

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
    // Or whether one of an earlier thread's is.
    bool is_first_of_fan(const step::Corner& corner) const {
        bool first = true;
        step::each_of_fan(view_, corner,
                          [&](const step::Corner& c) { return first = c.number() > corner.number(); });
        return first;
    }
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
    // But those of vertices of which several threads found fans: the first thread numbers these, in order.
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
    // Of the fan with this first corner.
    void number(std::uint32_t corner) {
        const std::uint32_t v = lattice_.triangles[corner / 3][corner % 3];
        cut_.points[next_[v]] = lattice_.points[v];
        numbers_[corner] = next_[v]++;
    }
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
    RawVector<std::uint32_t> first_corners_;          // of corners' fans
    RawVector<std::uint32_t> numbers_;                // of first corners: the new vertices
    std::vector<std::uint32_t> fan_counts_;           // of vertices
    std::vector<std::uint32_t> next_;                 // of vertices: the number of the next new one
    std::vector<int> finders_;                        // of vertices: the thread that found their fans
    std::vector<std::uint32_t> kept_before_;          // of threads: triangles that those before keep
    std::vector<std::vector<std::uint32_t>> shared_;  // of threads: first corners left to the first thread
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
