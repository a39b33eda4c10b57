// Walks through the fans of triangles around a vertex, which are connected by closed edges, and gives each
// fan a vertex of its own, by a team of threads.
#pragma once

#include <cstddef>
#include <cstdint>

#include "pipeline/base/host_device.h"
#include "pipeline/base/shared_memory_step.h"
#include "pipeline/data/geometry.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief::step {

// A split lattice with its triangles' labels. Neighbours, Open: types of pointers to
// three values per triangle.
template <typename Neighbours, typename Open>
struct FanView {
    const Triangle* triangles;
    Neighbours neighbours;
    Open open;
    const std::uint8_t* kept;
};

// Corner k of a triangle.
struct Corner {
    std::uint32_t triangle, k;
    HEXRELIEF_HD std::uint32_t number() const { return 3 * triangle + k; }
};

// Returns which corner of a triangle a vertex is.
HEXRELIEF_HD std::uint32_t corner_of(const Triangle& t, std::uint32_t vertex) {
    return t[0] == vertex ? 0u : t[1] == vertex ? 1u : 2u;
}

// Moves from a corner of a kept triangle to the same vertex's corner in the triangle across one of its
// two edges there: the edge to the next corner if `next`, else the edge from the last one. Returns
// false if that edge is open or no kept triangle lies across it. The lower triangle's entry decides
// whether an edge is open.
template <typename View>
HEXRELIEF_HD bool next_in_fan(const View& view, bool next, Corner& at) {
    const std::uint32_t t = at.triangle, edge = next ? at.k : (at.k + 2) % 3;
    const std::int32_t n = view.neighbours[t][edge];
    if (n < 0) return false;
    // all loads come before the first use, because each takes long on a GPU
    const std::uint32_t other = static_cast<std::uint32_t>(n), vertex = view.triangles[t][at.k];
    const Triangle corners = view.triangles[other];
    const std::uint8_t open[3] = {view.open[other][0], view.open[other][1], view.open[other][2]},
                       own_open = view.open[t][edge], kept = view.kept[other];
    const std::uint32_t k = corner_of(corners, vertex), back = next ? (k + 2) % 3 : k;
    if (!kept || (t < other ? own_open : back == 0 ? open[0] : back == 1 ? open[1] : open[2])) return false;
    at = {other, k};
    return true;
}

// Calls visit(corner) for the other corners of a corner's fan. In each of the two directions it stops
// when visit() returns false.
template <typename View, typename Visit>
HEXRELIEF_HD void each_of_fan(const View& view, const Corner& from, const Visit& visit) {
    for (int way = 0; way < 2; ++way) {
        Corner at = from;
        while (next_in_fan(view, way == 0, at)) {
            if (at.triangle == from.triangle) return;  // walked all around the vertex
            if (!visit(at)) return;
        }
    }
}

// A fan is identified by its first corner, the one with the lowest number.
struct FanArrays {
    std::uint32_t* firsts;  // per corner: the first corner of its fan; kNone if there is no cut at its vertex
    std::uint32_t* next;    // per first corner: another one at its vertex
    std::uint32_t* lists;   // per vertex: one of its first corners, kNone = none
    std::uint32_t* fans;    // per vertex: the number of its fans
    std::uint32_t* numbers;  // per vertex: that of its first copy
    std::uint32_t* copies;   // per first corner: the number of its vertex
    std::uint32_t* indices;  // per triangle: its index in the mesh
};

// The mesh that is cut: its vertices' places and source triangles, with room for most_points vertices.
struct CutMeshView {
    Vec2f* points;
    Triangle* triangles;
    std::uint32_t* source_triangles;
    unsigned most_points;
};

struct CutMeshSize {
    unsigned points, triangles;
};

// View: FanView.
template <typename Team, typename View>
class VertexCutter {
  public:
    // cuts: of CutArrays.
    HEXRELIEF_TEAM VertexCutter(Team& team, const View& view, unsigned points, unsigned triangles,
                                const unsigned* cuts, const FanArrays& arrays)
        : team_(team), view_(view), points_(points), triangles_(triangles), cuts_(cuts), a_(arrays) {}

    // Numbers the fans, which become vertices, and the kept triangles. Vertices are in the order of their
    // source vertices, those of one source vertex in that of their fans' first corners.
    HEXRELIEF_TEAM CutMeshSize number() const {
        team_.each(points_, [&](std::size_t v) {
            a_.lists[v] = kNone;
            a_.fans[v] = 0;
        });
        team_.each(std::size_t{3} * triangles_,
                   [&](std::size_t i) { find_fan(static_cast<std::uint32_t>(i)); });
        const unsigned points = exclusive_scan(
            team_, points_, [&](std::size_t v) -> unsigned { return a_.fans[v]; },
            [&](std::size_t v, unsigned before) { number_fans(v, before); });
        const unsigned triangles = exclusive_scan(
            team_, triangles_, [&](std::size_t t) -> unsigned { return view_.kept[t]; },
            [&](std::size_t t, unsigned before) { a_.indices[t] = before; });
        return {points, triangles};
    }
    // Writes the numbered mesh; vertices without room are left out.
    HEXRELIEF_TEAM void write(const Vec2f* positions, const CutMeshView& mesh) const {
        team_.each(points_, [&](std::size_t v) {
            const auto put = [&](unsigned number) {
                if (number < mesh.most_points) mesh.points[number] = positions[v];
            };
            if (cuts_[v] == 0 && a_.fans[v] != 0) put(a_.numbers[v]);
            for (std::uint32_t i = a_.lists[v]; i != kNone; i = a_.next[i]) put(a_.copies[i]);
        });
        team_.each(triangles_, [&](std::size_t t) {
            if (!view_.kept[t]) return;
            const Triangle v = view_.triangles[t];
            const auto number = [&](unsigned k) {
                const std::uint32_t first = a_.firsts[3 * t + k];
                return first == kNone ? a_.numbers[v[k]] : a_.copies[first];
            };
            mesh.triangles[a_.indices[t]] = {number(0), number(1), number(2)};
            mesh.source_triangles[a_.indices[t]] = static_cast<std::uint32_t>(t);
        });
    }

  private:
    static constexpr std::uint32_t kNone = 0xffffffffu;

    // Finds the first corner of a corner's fan. Around a vertex without cuts there is a single fan.
    HEXRELIEF_TEAM void find_fan(std::uint32_t corner) const {
        const std::uint32_t t = corner / 3, k = corner % 3;
        if (!view_.kept[t]) return;
        const std::uint32_t v = view_.triangles[t][k];
        if (cuts_[v] == 0) {
            a_.firsts[corner] = kNone;
            store(a_.fans + v, std::uint32_t{1});
            return;
        }
        std::uint32_t first = corner;
        each_of_fan(view_, {t, k}, [&](const Corner& c) {
            first = min_of(first, c.number());
            return true;
        });
        a_.firsts[corner] = first;
        if (first != corner) return;
        add_to(a_.fans + v, 1);
        a_.next[corner] = exchange(a_.lists + v, corner);
    }
    HEXRELIEF_TEAM void number_fans(std::size_t v, unsigned before) const {
        a_.numbers[v] = before;
        for (std::uint32_t i = a_.lists[v]; i != kNone; i = a_.next[i]) {
            std::uint32_t number = before;
            for (std::uint32_t j = a_.lists[v]; j != kNone; j = a_.next[j]) number += j < i;
            a_.copies[i] = number;
        }
    }

    Team& team_;
    const View& view_;
    unsigned points_, triangles_;
    const unsigned* cuts_;
    const FanArrays& a_;
};

}  // namespace hexrelief::step
