#include "mesher/surface/topology/snap_vertices.h"

#include <algorithm>
#include <array>

#include "mesher/surface/pixels/crack_query.h"
#include "mesher/surface/pixels/edge_crossings_step.h"

namespace hexrelief::surface {
namespace {

constexpr float kNotListed = -1;  // share of a vertex that is not a candidate

// The crossings of a vertex's edges with silhouettes.
struct Crossings {
    std::array<float, 6> shares{-1, -1, -1, -1, -1, -1};  // per edge; below 0: no crossing
    bool fresh = true;                                    // true until the first refresh()
    std::uint8_t on_silhouette = 0;  // bit k: neighbour k lay on a silhouette at the last refresh()
    Vec2f nearest;                   // the nearest crossing
};

// Moves the candidates in order of their distance from the silhouette. A vertex moves at most once, and its
// move depends only on itself and its six neighbours. So each thread goes through its own vertices in order
// and defers those that come after a neighbour of another thread or after a deferred neighbour; in the end
// the first thread goes through the deferred ones. The result is that of a single thread in order.
class VertexSnapper {
  public:
    VertexSnapper(const PixelSurfaces& surfaces, const step::LatticePart& part, HexMesh2D& mesh,
                  ThreadPool& pool)
        : surfaces_(surfaces),
          query_{surfaces.view(), surfaces.tiles()},
          part_(part),
          mesh_(mesh),
          lattice_{mesh.columns, mesh.rows},
          pool_(pool),
          on_silhouette_(mesh.positions.size(), 0),
          deferred_(mesh.positions.size()),
          listed_shares_(mesh.positions.size()),
          shares_(mesh.positions.size()),
          crossings_(mesh.positions.size()),
          candidates_(pool.size()) {}

    std::vector<std::uint8_t> run() {
        ThreadPool::ChunkCounters found(pool_.size()), refreshed(pool_.size());
        const std::size_t count = mesh_.positions.size();
        pool_.run([&](int thread) {
            for (std::size_t v = pool_.share(count, thread), end = pool_.share(count, thread + 1); v < end;
                 ++v)
                crossings_[v] = {};
            pool_.barrier();
            pool_.run_chunks(count, thread, found,
                             [&](std::size_t v) { find_first_crossings(static_cast<std::uint32_t>(v)); });
            pool_.barrier();
            pool_.run_chunks(count, thread, refreshed,
                             [&](std::size_t v) { refresh(static_cast<std::uint32_t>(v)); });
            pool_.barrier();
            if (thread == 0) share_out();
            pool_.barrier();
            list_candidates(thread);
            pool_.barrier();
            visit_own(thread);
            pool_.barrier();
            if (thread == 0) visit_deferred();
        });
        return std::move(on_silhouette_);
    }

  private:
    struct Candidate {
        float share;
        std::uint32_t v;
    };
    void sort(std::vector<Candidate>& list) const {
        std::sort(list.begin(), list.end(), [this](const Candidate& a, const Candidate& b) {
            return step::goes_before(part_, a.share, a.v, b.share, b.v);
        });
    }

    bool is_candidate(std::uint32_t v) const { return shares_[v] >= 0 && shares_[v] <= step::kSnapReach; }
    // Gives each thread a contiguous range of vertices that holds its share of the candidates.
    void share_out() {
        const std::uint32_t count = static_cast<std::uint32_t>(mesh_.positions.size());
        std::size_t all = 0, before = 0;
        for (std::uint32_t v = 0; v < count; ++v) all += is_candidate(v);
        firsts_.assign(1, 0);
        for (std::uint32_t v = 0; v < count; ++v) {
            while (before > pool_.share(all, static_cast<int>(firsts_.size()))) firsts_.push_back(v);
            before += is_candidate(v);
        }
        firsts_.resize(static_cast<std::size_t>(pool_.size()) + 1, count);
    }
    // Lists the thread's candidates in order.
    void list_candidates(int thread) {
        std::vector<Candidate>& list = candidates_[thread];
        list.clear();
        for (std::uint32_t v = firsts_[thread]; v < firsts_[thread + 1]; ++v) {
            deferred_[v] = 0;
            listed_shares_[v] = is_candidate(v) ? shares_[v] : kNotListed;
            if (listed_shares_[v] != kNotListed) list.push_back({listed_shares_[v], v});
        }
        sort(list);
    }
    // Moves the thread's candidates and defers those that depend on an earlier one of another thread.
    void visit_own(int thread) {
        const std::uint32_t first = firsts_[thread], end = firsts_[thread + 1];
        std::vector<Candidate> deferred;
        for (const auto& [share, v] : candidates_[thread]) {
            each_neighbour(v, [&, share = share, v = v](std::uint32_t u, int) {
                if (listed_shares_[u] == kNotListed ||
                    !step::goes_before(part_, listed_shares_[u], u, share, v))
                    return;
                if (u < first || u >= end || deferred_[u]) deferred_[v] = 1;
            });
            if (deferred_[v])
                deferred.push_back({share, v});
            else
                visit(v);
        }
        candidates_[thread].swap(deferred);
    }
    void visit_deferred() {
        std::vector<Candidate> all;
        for (const auto& list : candidates_) all.insert(all.end(), list.begin(), list.end());
        sort(all);
        for (const auto& [share, v] : all) visit(v);
    }
    void visit(std::uint32_t v) {
        refresh(v);  // its neighbours may have moved
        if (is_candidate(v)) snap(v);
    }

    int column(std::uint32_t v) const { return static_cast<int>(v % mesh_.columns); }
    int row(std::uint32_t v) const { return static_cast<int>(v / mesh_.columns); }
    // Calls visit(u, k) for each neighbour u, the k-th, of a vertex.
    template <typename Visit>
    void each_neighbour(std::uint32_t v, const Visit& visit) const {
        const int at_column = column(v), at_row = row(v);
        for (int k = 0; k < 6; ++k) {
            const int u = step::neighbour_at(lattice_, at_column, at_row, k);
            if (u >= 0) visit(static_cast<std::uint32_t>(u), k);
        }
    }
    // Finds the first crossings of the edges to higher neighbours from either end, with the same result as
    // open_crossing() while no vertex lies on a silhouette.
    void find_first_crossings(std::uint32_t v) {
        const Vec2f& p = mesh_.positions[v];
        int others[3];
        Vec2f lower = p, upper = p;
        for (int k = 0; k < 3; ++k) {
            others[k] = step::neighbour_at(lattice_, column(v), row(v), k);
            if (others[k] < 0) continue;
            const Vec2f& q = mesh_.positions[others[k]];
            lower = {std::min(lower.x, q.x), std::min(lower.y, q.y)};
            upper = {std::max(upper.x, q.x), std::max(upper.y, q.y)};
        }
        if (!surfaces_.may_cross(lower, upper)) return;
        for (int k = 0; k < 3; ++k) {
            const int u = others[k];
            if (u < 0) continue;
            const Vec2f& q = mesh_.positions[u];
            if (!surfaces_.may_cross(p, q) || !surfaces_.may_meet(p, q)) continue;
            const WayDiscontinuities discontinuities = query_.discontinuities_between(p, q, false);
            if (!discontinuities.found) continue;
            const step::SilhouettePoint silhouette = query_.silhouette_point(discontinuities.first);
            crossings_[v].shares[k] = step::meet(silhouette, p.x, p.y, q.x, q.y);
            crossings_[u].shares[k + 3] = step::meet(discontinuities.last == discontinuities.first
                                                         ? silhouette
                                                         : query_.silhouette_point(discontinuities.last),
                                                     q.x, q.y, p.x, p.y);
        }
    }
    // Searches the crossings of the edges to neighbours that have moved again.
    void refresh(std::uint32_t v) {
        Crossings& c = crossings_[v];
        if (on_silhouette_[v]) {
            shares_[v] = -1;
            return;
        }
        std::uint8_t on_silhouette = 0;
        each_neighbour(v, [&](std::uint32_t u, int k) { on_silhouette |= on_silhouette_[u] << k; });
        const int stale = on_silhouette ^ c.on_silhouette;
        if (stale == 0 && !c.fresh) return;
        c.fresh = false;
        c.on_silhouette = on_silhouette;
        const Vec2f& p = mesh_.positions[v];
        each_neighbour(v, [&](std::uint32_t u, int k) {
            if (!(stale >> k & 1)) return;
            const Vec2f& q = mesh_.positions[u];
            const bool may_cross = surfaces_.may_cross(p, q) && surfaces_.may_meet(p, q);
            c.shares[k] = may_cross ? step::open_crossing(query_, p, false, q, on_silhouette_[u], v < u) : -1;
        });
        const auto nearest = step::nearest_crossing([&](int k) { return c.shares[k]; });
        shares_[v] = nearest.share;
        if (!(nearest.share >= 0)) return;
        const int u = step::neighbour_at(lattice_, column(v), row(v), nearest.k);
        c.nearest = step::between(p, mesh_.positions[u], nearest.share);
    }
    // Moves a vertex to the silhouette's nearest point or, if triangles forbid that, to the crossing.
    void snap(std::uint32_t v) {
        const Vec2f crossing = crossings_[v].nearest;
        if (!try_move(v, step::nearest_silhouette(query_, mesh_.positions[v], crossing)))
            try_move(v, crossing);
    }
    bool try_move(std::uint32_t v, Vec2f to) {
        const Vec2f from = mesh_.positions[v];
        if (!step::keep_in_image(from, static_cast<float>(query_.pixels.width),
                                 static_cast<float>(query_.pixels.height), to))
            return false;
        const float after = worst_shape(v, to);
        if (!(after >= step::kLeastShape) && !(after >= worst_shape(v, from))) return false;
        mesh_.positions[v] = to;
        on_silhouette_[v] = 1;
        return true;
    }
    // Returns the worst shape of the triangles around a vertex if it were at p.
    float worst_shape(std::uint32_t v, const Vec2f& p) const {
        float worst = 1;
        const int at_column = column(v), at_row = row(v);
        for (int i = 0; i < 8; ++i) {
            Triangle t;
            if (!step::triangle_around(lattice_, at_column, at_row, i, t)) continue;
            const auto at = [&](int k) { return t[k] == v ? p : mesh_.positions[t[k]]; };
            worst = step::min_of(worst, step::shape(at(0), at(1), at(2)));
        }
        return worst;
    }

    const PixelSurfaces& surfaces_;
    CrackQuery query_;
    step::LatticePart part_;
    HexMesh2D& mesh_;
    step::Lattice lattice_;
    ThreadPool& pool_;
    std::vector<std::uint8_t> on_silhouette_;
    RawVector<std::uint8_t> deferred_;  // true if left to the first thread
    RawVector<float> listed_shares_;    // the candidates' shares when they were listed
    RawVector<float> shares_;           // per vertex: least share of its crossings; below 0: none
    RawVector<Crossings> crossings_;
    std::vector<std::uint32_t> firsts_;               // per thread the first vertex of its range, and the end
    std::vector<std::vector<Candidate>> candidates_;  // per thread
};

}  // namespace

std::vector<std::uint8_t> snap_to_silhouettes(const PixelSurfaces& surfaces, const step::LatticePart& part,
                                              HexMesh2D& mesh, ThreadPool& pool) {
    return VertexSnapper(surfaces, part, mesh, pool).run();
}

}  // namespace hexrelief::surface
