// Gives each vertex fan a vertex of its own, by a team of threads.
#pragma once

#include <cstddef>
#include <cstdint>

#include "mesher/surface/topology/vertex_fans_step.h"
#include "pipeline/base/shared_memory_step.h"
#include "pipeline/data/geometry.h"

namespace hexrelief::step {

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
