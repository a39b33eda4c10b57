#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>

#include "mesher/buckets.h"
#include "mesher/sheet_parts.h"
#include "mesher/steps/free_corners.h"
#include "mesher/steps/rim_fit.h"

namespace hexrelief {
namespace {

constexpr float kStay_px = 1.0f;  // vertices move less mostly: the sides around are found once

using step::RimPull;

// Sides of pixels, as step::RimSide; the first `count` are in use.
struct PixelSides {
    std::vector<float> x, y, near_x, near_y;
    std::size_t count = 0;

    void make_room(std::size_t more) {
        if (count + more <= x.size()) return;
        for (std::vector<float>* v : {&x, &y, &near_x, &near_y}) v->resize(2 * (count + more));
    }
    void add(const step::RimSide& side, bool counts) {
        x[count] = side.x;
        y[count] = side.y;
        near_x[count] = side.near_x;
        near_y[count] = side.near_y;
        count += counts;
    }
};

// Flags of up to eight pixels from `first` on, the first in the lowest byte.
std::uint64_t flags_of(const std::uint8_t* first, int count, const std::uint8_t* end) {
    std::uint64_t flags = 0;
    if (std::endian::native == std::endian::little && end - first >= 8)
        std::memcpy(&flags, first, 8);
    else
        for (int k = 0; k < std::min(8, count); ++k) flags |= std::uint64_t{first[k]} << 8 * k;
    return count < 8 ? flags & ((std::uint64_t{1} << 8 * count) - 1) : flags;
}

// Writes what the edge sees of sides from `first` on.
#if defined(__x86_64__)
__attribute__((target_clones("avx512f", "avx2", "default")))
#endif
void see(const step::RimEdgeFrame& edge, const PixelSides& sides, std::size_t first, std::size_t count,
         RimPull* pulls) {
    const step::RimEdgeFrame e = edge;
    const float *x = sides.x.data() + first, *y = sides.y.data() + first;
    const float *near_x = sides.near_x.data() + first, *near_y = sides.near_y.data() + first;
#pragma GCC ivdep
    for (std::size_t i = 0; i < count; ++i) pulls[i] = step::rim_pull(e, {x[i], y[i], near_x[i], near_y[i]});
}

// Items of a thread's list.
struct Items {
    std::size_t first = 0, end = 0;
};

struct RimEdge {
    std::uint32_t a = 0, b = 0;
    float nx = 0, ny = 0;      // unit, to the left
    int thread = -1;           // whose list holds its sides
    Vec2f from_a{}, from_b{};  // where its vertices were when its sides were found
    Items sides{};
    step::RimPulls pulls{};
};

class RimFitter {
  public:
    RimFitter(const PixelSurfaces& surfaces, const TriangleSides& sides, SplitLattice& lattice, Team& team)
        : view_(surfaces.view()), sides_(sides), lattice_(lattice), team_(team), lists_(team.size()) {}

    void run() {
        find_rims();
        moved_.assign(vertices_.size(), 1);
        marked_.assign(vertices_.size(), 0);
        targets_ = next_ = lattice_.points;
        team_.run([&](int thread) {
            Vec2f *points = lattice_.points.data(), *next = next_.data();
            const auto each = [&](std::size_t count, const auto& visit) {
                team_.each_piece(count, thread, [&](std::size_t first, std::size_t last) {
                    for (std::size_t i = first; i < last; ++i) visit(i);
                });
            };
            for (int round = 0; round < step::kRimRounds; ++round) {
                each(edges_.size(), [&](std::size_t e) {
                    if (has_moved(edges_[e])) find_pulls(points, edges_[e], thread);
                });
                team_.barrier();
                each(vertices_.size(), [&](std::size_t i) {
                    if (has_moved_around(i)) targets_[vertices_[i]] = target(points, i);
                });
                team_.barrier();
                each(triangles_.size(), [&](std::size_t i) { judge(points, triangles_[i]); });
                team_.barrier();
                each(vertices_.size(), [&](std::size_t i) {
                    const std::uint32_t v = vertices_[i];
                    moved_[i] = !(targets_[v] == points[v]) && may_move(i);
                    next[v] = moved_[i] ? targets_[v] : points[v];
                    if (moved_[i] && !marked_[i]) mark(i);
                });
                team_.barrier();
                std::swap(points, next);
            }
        });
        if (step::kRimRounds % 2 == 1) lattice_.points.swap(next_);
    }

  private:
    static constexpr std::uint32_t kNone = 0xffffffffu;

    bool has_moved(const RimEdge& edge) const { return moved_[place_[edge.a]] || moved_[place_[edge.b]]; }
    bool has_moved_around(std::size_t i) const {
        const auto ends = ends_[i];
        return std::any_of(ends.begin(), ends.end(),
                           [&](std::uint32_t end) { return has_moved(edges_[end / 2]); });
    }
    // Of a thread's share of triangles. No branches that cannot be foreseen.
    void find_edges(int thread) {
        const std::int32_t end =
            static_cast<std::int32_t>(team_.share(lattice_.triangles.size(), thread + 1));
        for (std::int32_t t = static_cast<std::int32_t>(team_.share(lattice_.triangles.size(), thread));
             t < end; ++t)
            for (int k = 0; k < 3; ++k) {
                const std::int32_t n = lattice_.neighbours[t][k];
                const bool once = n >= t;  // none at the image's border
                if (!(once & step::is_rim(sides_.kept[t] != 0, sides_.kept[once ? n : t] != 0,
                                          sides_.open[t][k] != 0)))
                    continue;
                lists_[thread].edges.push_back(
                    {.a = lattice_.triangles[t][k], .b = lattice_.triangles[t][(k + 1) % 3]});
            }
    }
    void find_rims() {
        team_.run([&](int thread) { find_edges(thread); });
        edges_ = std::move(lists_[0].edges);
        for (int thread = 1; thread < team_.size(); ++thread)
            edges_.insert(edges_.end(), lists_[thread].edges.begin(), lists_[thread].edges.end());
        place_.assign(lattice_.points.size(), kNone);
        for (const RimEdge& edge : edges_) place_[edge.a] = place_[edge.b] = 0;
        for (std::uint32_t v = 0; v < place_.size(); ++v) {
            if (place_[v] == kNone) continue;
            place_[v] = static_cast<std::uint32_t>(vertices_.size());
            vertices_.push_back(v);
        }
        team_.run([&](int thread) {
            if (thread == 0) find_ends();
            if (thread == team_.size() - 1) find_corners();
        });
    }
    void find_ends() {
        ends_ = sort_into(vertices_.size(), [&](const auto& put) {
            for (std::uint32_t e = 0; e < edges_.size(); ++e)
                put(place_[edges_[e].a], 2 * e), put(place_[edges_[e].b], 2 * e + 1);
        });
    }
    void find_corners() {
        for (std::uint32_t t = 0; t < lattice_.triangles.size(); ++t) {
            const Triangle& n = lattice_.triangles[t];
            if ((place_[n[0]] & place_[n[1]] & place_[n[2]]) != kNone) triangles_.push_back(t);
        }
        corners_ = sort_into(vertices_.size(), [&](const auto& put) {
            for (const std::uint32_t t : triangles_)
                for (unsigned k = 0; k < 3; ++k) {
                    const std::uint32_t place = place_[lattice_.triangles[t][k]];
                    if (place != kNone) put(place, 3 * t + k);
                }
        });
        free_.resize(lattice_.triangles.size());
    }
    // All sides near an edge, and as far around as its vertices may move before they are found anew.
    void find_sides(const Vec2f& p, const Vec2f& q, RimEdge& edge, PixelSides& sides) const {
        edge.from_a = p;
        edge.from_b = q;
        edge.sides.first = sides.count;
        constexpr float kAround_px = step::kRimFitReach_px + kStay_px;
        const step::PixelBox box = step::pixels_around(view_, p, q, kAround_px);
        const float dx = q.x - p.x, dy = q.y - p.y, size2 = dx * dx + dy * dy;
        const float most =
            (kAround_px + 0.01f) * (kAround_px + 0.01f) * size2;  // 0.01: more than rounding may do
        const std::uint8_t* end = view_.flags + view_.index(0, view_.height);
        for (int y = box.y0; y <= box.y1; ++y)
            for (int x0 = box.x0; x0 <= box.x1; x0 += 8) {
                std::uint64_t jumps = flags_of(view_.flags + view_.index(x0, y), box.x1 - x0 + 1, end) &
                                      0x0101010101010101u * (step::kJumpRight | step::kJumpDown);
                sides.make_room(16);
                for (; jumps != 0; jumps &= jumps - 1) {
                    const int bit = std::countr_zero(jumps);
                    const step::RimSide side = step::rim_side(view_, {x0 + bit / 8, y, bit % 8});
                    const float off = (side.y - p.y) * dx - (side.x - p.x) * dy;
                    sides.add(side, off * off <= most);  // no branch, which could not be foreseen
                }
            }
        edge.sides.end = sides.count;
    }
    static bool has_left(const Vec2f& from, const Vec2f& p) {
        const float dx = p.x - from.x, dy = p.y - from.y;
        return dx * dx + dy * dy > kStay_px * kStay_px;
    }
    void find_pulls(const Vec2f* points, RimEdge& edge, int thread) {
        PixelSides& sides = lists_[thread].sides;
        std::vector<RimPull>& seen = lists_[thread].seen;
        const Vec2f &p = points[edge.a], &q = points[edge.b];
        if (edge.thread < 0 || has_left(edge.from_a, p) || has_left(edge.from_b, q))
            find_sides(p, q, edge, sides);
        edge.thread = thread;
        edge.pulls = {};
        const step::RimEdgeFrame frame = step::rim_edge_frame(p, q);
        if (!(frame.size2 > 0)) return;
        edge.nx = frame.nx;
        edge.ny = frame.ny;
        const std::size_t count = edge.sides.end - edge.sides.first;
        if (seen.size() < count) seen.resize(count);
        see(frame, sides, edge.sides.first, count, seen.data());
        double facing = 0;
        for (std::size_t i = 0; i < count; ++i) facing += seen[i].weight * seen[i].across;
        for (std::size_t i = 0; i < count; ++i) step::add_pull(edge.pulls, seen[i], facing);
    }
    // Where the i-th rim vertex would go, from the edges at it.
    Vec2f target(const Vec2f* points, std::size_t i) const {
        step::RimEquation e;
        for (const std::uint32_t end : ends_[i]) {
            const RimEdge& edge = edges_[end / 2];
            step::add_edge(e, edge.nx, edge.ny, edge.pulls.weights[end % 2], edge.pulls.residuals[end % 2]);
        }
        return step::rim_target(e, points[vertices_[i]], static_cast<float>(view_.width),
                                static_cast<float>(view_.height));
    }
    void judge(const Vec2f* points, std::uint32_t t) {
        const Triangle& n = lattice_.triangles[t];
        const Vec2f from[3] = {points[n[0]], points[n[1]], points[n[2]]};
        const Vec2f to[3] = {targets_[n[0]], targets_[n[1]], targets_[n[2]]};
        free_[t] = static_cast<std::uint8_t>(step::free_corners(from, to, step::kRimLeastShape));
    }
    bool may_move(std::size_t i) const {
        const auto corners = corners_[i];
        return std::all_of(corners.begin(), corners.end(),
                           [&](std::uint32_t corner) { return (free_[corner / 3] >> corner % 3 & 1) != 0; });
    }
    void mark(std::size_t i) {
        marked_[i] = 1;
        for (const std::uint32_t corner : corners_[i]) {
            const std::atomic_ref<std::uint8_t> changed(lattice_.changed[corner / 3]);
            if (changed.load(std::memory_order_relaxed) == SplitLattice::kSame)
                changed.store(SplitLattice::kMoved, std::memory_order_relaxed);
        }
    }

    step::PixelView view_;
    const TriangleSides& sides_;
    SplitLattice& lattice_;
    Team& team_;
    std::vector<RimEdge> edges_;
    std::vector<std::uint32_t> vertices_, place_;  // on rims, ascending; a vertex: where it is among them
    std::vector<std::uint32_t> triangles_;         // with such a vertex
    Buckets ends_, corners_;          // at each rim vertex: 2 * edge + which, 3 * triangle + which
    std::vector<std::uint8_t> free_;  // a triangle's corners that may move, as bits
    struct Lists {
        PixelSides sides;
        std::vector<RimPull> seen;   // of one edge
        std::vector<RimEdge> edges;  // found by the thread
    };
    std::vector<Lists> lists_;                  // of a thread's edges
    std::vector<Vec2f> targets_, next_;         // of all vertices
    std::vector<std::uint8_t> moved_, marked_;  // rim vertices: in the round before; ever
};

}  // namespace

void fit_rims(const PixelSurfaces& surfaces, const TriangleSides& sides, SplitLattice& lattice, Team& team) {
    RimFitter(surfaces, sides, lattice, team).run();
}

}  // namespace hexrelief
