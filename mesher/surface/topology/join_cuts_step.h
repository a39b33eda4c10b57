// Opens closed edges between the ends of two cuts, by a team of threads.
#pragma once

#include <cstddef>
#include <cstdint>

#include "mesher/surface/topology/cut_vertices_step.h"
#include "pipeline/base/shared_memory_step.h"

namespace hexrelief::step {

struct CutArrays {
    unsigned* cuts;  // per vertex: number of cut edges at it
    // per vertex: the first edge there that is still to be decided, combined with its round
    std::uint64_t* next_edges[2];
    std::uint32_t* joins;  // edges that may be opened, three entries per triangle, as 3 * triangle + k
    unsigned* count;       // of joins
};

// The edge from corner k of triangle t to the next corner, with triangle n across it, or -1.
struct TriangleEdge {
    std::uint32_t t, k;
    std::int32_t n;
    std::uint32_t a, b;  // its end vertices
    HEXRELIEF_HD std::uint32_t number() const { return 3 * t + k; }
};

// The few pixel pairs of an edge err now and then, and one closed edge in a cut holds both surfaces together
// as far as the next vertices: without this step teddy at full size has 3.6 instead of 2.9 % of rubber sheet
// (triangles across a discontinuity). Each edge that is opened changes the condition for the next one, so
// edges are opened in the order of their numbers as far as it matters: one is decided once no lower edge at
// its ends is undecided. View: FanView with `open` to be written.
template <typename Team, typename View>
class CutJoiner {
  public:
    HEXRELIEF_TEAM CutJoiner(Team& team, const View& view, const CutArrays& arrays)
        : team_(team), view_(view), a_(arrays) {}

    // Writes `cuts` as well. All threads of the team call.
    HEXRELIEF_TEAM void join(unsigned points, unsigned triangles) const {
        if (team_.is_first()) *a_.count = 0;
        team_.each(points, [&](std::size_t v) {
            a_.cuts[v] = 0;
            a_.next_edges[0][v] = a_.next_edges[1][v] = ~std::uint64_t{0};
        });
        each_edge(triangles, [&](const TriangleEdge& e, bool kept, bool other_kept, bool open) {
            if (kept == other_kept && !(kept && open)) return;
            add_to(a_.cuts + e.a, 1);
            add_to(a_.cuts + e.b, 1);
        });
        each_edge(triangles, [&](const TriangleEdge& e, bool kept, bool other_kept, bool open) {
            if (!kept || !other_kept || open || a_.cuts[e.a] != 1 || a_.cuts[e.b] != 1) return;
            a_.joins[add_to(a_.count, 1)] = e.number();
            queue(e, 0);
        });
        const unsigned count = *a_.count;
        for (unsigned round = 0;; ++round) {
            bool waits = false;
            team_.each(count, [&](std::size_t i) { waits = decide(a_.joins[i], round) || waits; });
            if (!team_.any(waits)) return;
        }
    }

  private:
    static constexpr std::uint32_t kNone = 0xffffffffu;

    HEXRELIEF_TEAM TriangleEdge edge(std::uint32_t t, std::uint32_t k) const {
        const Triangle& v = view_.triangles[t];
        return {t, k, view_.neighbours[t][k], v[k], v[(k + 1) % 3]};
    }
    // Calls visit(edge, whether its triangle is kept, that across it, whether it is open) once for each edge,
    // from its lower triangle.
    template <typename Visit>
    HEXRELIEF_TEAM void each_edge(unsigned triangles, const Visit& visit) const {
        team_.each(triangles, [&](std::size_t i) {
            const std::uint32_t t = static_cast<std::uint32_t>(i);
            const bool kept = view_.kept[t] != 0;
            HEXRELIEF_UNROLL
            for (std::uint32_t k = 0; k < 3; ++k) {
                const TriangleEdge e = edge(t, k);
                if (e.n < 0 || e.n > static_cast<std::int32_t>(t))
                    visit(e, kept, e.n >= 0 && view_.kept[e.n] != 0, view_.open[t][k] != 0);
            }
        });
    }
    // Returns a number that orders edges; those of later rounds are lower, so that they replace earlier ones.
    HEXRELIEF_TEAM static std::uint64_t priority(const TriangleEdge& e, unsigned round) {
        return static_cast<std::uint64_t>(~round) << 32 | e.number();
    }
    HEXRELIEF_TEAM void queue(const TriangleEdge& e, unsigned round) const {
        std::uint64_t* const next_edges = a_.next_edges[round % 2];
        lower_to(next_edges + e.a, priority(e, round));
        lower_to(next_edges + e.b, priority(e, round));
    }
    // Opens a listed edge whose ends have one cut each when it is its turn. True if it waits for the next
    // round.
    HEXRELIEF_TEAM bool decide(std::uint32_t& listed, unsigned round) const {
        if (listed == kNone) return false;
        const TriangleEdge e = edge(listed / 3, listed % 3);
        const unsigned a = load(a_.cuts + e.a), b = load(a_.cuts + e.b);
        const std::uint64_t own = priority(e, round), *next_edges = a_.next_edges[round % 2];
        const bool now = next_edges[e.a] == own && next_edges[e.b] == own;
        if (now && a == 1 && b == 1) {
            open(e);
            add_to(a_.cuts + e.a, 1);
            add_to(a_.cuts + e.b, 1);
        }
        if (now || a > 1 || b > 1) {
            listed = kNone;
            return false;
        }
        queue(e, round + 1);
        return true;
    }
    HEXRELIEF_TEAM void open(const TriangleEdge& e) const {
        view_.open[e.t][e.k] = 1;
        for (int m = 0; m < 3; ++m)
            if (view_.neighbours[e.n][m] == static_cast<std::int32_t>(e.t)) {
                view_.open[e.n][m] = 1;
                return;
            }
    }

    Team& team_;
    const View& view_;
    const CutArrays& a_;
};

}  // namespace hexrelief::step
