#include "pipeline/stages/surface_topology.h"

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <bit>
#include <span>
#include <stdexcept>

#include "pipeline/data/counting_sort.h"
#include "pipeline/data/union_find.h"

namespace hexrelief::stages {
namespace {

// Returns the corners of each vertex, as 3 * triangle + corner, ascending.
Buckets corners_by_vertex(const std::vector<Triangle>& triangles, std::size_t vertex_count) {
    return sort_into(vertex_count, [&](const auto& put) {
        std::uint32_t corner = 0;
        for (const Triangle& triangle : triangles)
            for (const std::uint32_t vertex : triangle) put(vertex, corner++);
    });
}

// Divides the corners of one vertex into fans: two corners are in the same fan if their triangles are
// connected through edges at the vertex.
class VertexFans {
  public:
    // Numbers the fans in the order of their first corners; returns how many there are.
    std::uint32_t find(const std::vector<Triangle>& triangles, std::span<const std::uint32_t> corners) {
        const std::uint32_t count = static_cast<std::uint32_t>(corners.size());
        if (is_one_fan(triangles, corners)) {
            numbers_.assign(count, 0);
            return 1;
        }
        outgoing_.clear();
        incoming_.clear();
        for (std::uint32_t a = 0; a < count; ++a) {
            const Triangle& t = triangles[corners[a] / 3];
            const std::uint32_t k = corners[a] % 3;
            outgoing_.push_back(t[k == 2 ? 0 : k + 1]);
            incoming_.push_back(t[k == 0 ? 2 : k - 1]);
        }
        // Two corners share an edge if the outgoing neighbour of one is the incoming neighbour of the other.
        next_.assign(count, count);
        previous_.assign(count, count);
        for (std::uint32_t a = 0; a < count; ++a)
            for (std::uint32_t b = 0; b < count; ++b)
                if (incoming_[b] == outgoing_[a]) next_[a] = b, previous_[b] = a;
        numbers_.assign(count, count);
        std::uint32_t fans = 0;
        for (std::uint32_t first = 0; first < count; ++first) {
            if (numbers_[first] != count) continue;
            for (std::uint32_t a = first; a != count && numbers_[a] == count; a = next_[a])
                numbers_[a] = fans;
            for (std::uint32_t a = previous_[first]; a != count && numbers_[a] == count; a = previous_[a])
                numbers_[a] = fans;
            ++fans;
        }
        return fans;
    }
    std::uint32_t operator[](std::uint32_t corner) const { return numbers_[corner]; }

  private:
    // True if the corners form one fan. Walks around the vertex from its first corner, both ways. Also false
    // if there are more than kMost corners.
    static bool is_one_fan(const std::vector<Triangle>& triangles, std::span<const std::uint32_t> corners) {
        constexpr std::uint32_t kMost = 8, kNone = 0xFFFFFFFFu;
        const std::uint32_t count = static_cast<std::uint32_t>(corners.size());
        if (count == 0 || count > kMost) return false;
        std::uint32_t outgoing[kMost], incoming[kMost];
        for (std::uint32_t a = 0; a < kMost; ++a) outgoing[a] = incoming[a] = kNone;
        for (std::uint32_t a = 0; a < count; ++a) {
            const Triangle& t = triangles[corners[a] / 3];
            const std::uint32_t k = corners[a] % 3;
            outgoing[a] = t[k == 2 ? 0 : k + 1];
            incoming[a] = t[k == 0 ? 2 : k - 1];
        }
        const auto where = [](const std::uint32_t(&list)[kMost], std::uint32_t value) {
            unsigned bits = 0;
            for (std::uint32_t b = 0; b < kMost; ++b) bits |= static_cast<unsigned>(list[b] == value) << b;
            return bits;
        };
        std::uint32_t seen = 1;
        for (std::uint32_t a = 0; seen < count; ++seen) {
            const unsigned next = where(incoming, outgoing[a]);
            if (next == 0) break;
            a = static_cast<std::uint32_t>(std::countr_zero(next));
            if (a == 0) return false;  // back at the first corner: a closed fan, and other fans beside it
        }
        for (std::uint32_t a = 0; seen < count; ++seen) {
            const unsigned previous = where(outgoing, incoming[a]);
            if (previous == 0) return false;
            a = static_cast<std::uint32_t>(std::countr_zero(previous));
        }
        return true;
    }

    std::vector<std::uint32_t> outgoing_, incoming_;  // the corner's neighbours within its triangle
    std::vector<std::uint32_t> next_, previous_;      // the next and the previous corner around the vertex
    std::vector<std::uint32_t> numbers_;
};

struct SurfaceTraits : OpenMesh::DefaultTraits {
    VertexAttributes(OpenMesh::Attributes::None);
    FaceAttributes(OpenMesh::Attributes::None);
    HalfedgeAttributes(OpenMesh::Attributes::PrevHalfedge);
};
using HalfedgeMesh = OpenMesh::TriMesh_ArrayKernelT<SurfaceTraits>;

HalfedgeMesh to_halfedges(const SurfaceMesh& surface) {
    HalfedgeMesh mesh;
    mesh.reserve(surface.positions.size(), surface.positions.size() + surface.triangles.size() + 64,
                 surface.triangles.size());
    for (const Vec3f& p : surface.positions) mesh.add_vertex({p.x, p.y, p.z});
    for (const Triangle& t : surface.triangles) {
        const auto vertex = [](std::uint32_t i) { return OpenMesh::VertexHandle(static_cast<int>(i)); };
        if (!mesh.add_face(vertex(t[0]), vertex(t[1]), vertex(t[2])).is_valid())
            throw std::logic_error("surface: a triangle does not fit a manifold");
    }
    return mesh;
}

}  // namespace

std::vector<std::uint32_t> split_fans(std::vector<Triangle>& triangles, std::size_t vertex_count) {
    const Buckets corners_of = corners_by_vertex(triangles, vertex_count);
    // The source vertex of each new vertex; the new vertex of each corner.
    std::vector<std::uint32_t> sources, numbers(corners_of.items.size());
    sources.reserve(vertex_count);
    VertexFans fans;
    for (std::uint32_t v = 0; v < vertex_count; ++v) {
        const std::span<const std::uint32_t> corners = corners_of[v];
        const std::uint32_t first = static_cast<std::uint32_t>(sources.size()),
                            found = fans.find(triangles, corners);
        for (std::uint32_t f = 0; f < found; ++f) sources.push_back(v);
        for (std::uint32_t a = 0; a < corners.size(); ++a) numbers[corners[a]] = first + fans[a];
    }
    std::uint32_t i = 0;
    for (Triangle& triangle : triangles)
        for (std::uint32_t& v : triangle) v = numbers[i++];
    return sources;
}

void drop_small_components(std::vector<Triangle>& triangles, std::size_t vertex_count, int min_triangles) {
    if (min_triangles <= 1) return;
    // After split_fans() triangles that share a vertex are connected by edges, so joining
    // vertices finds the components.
    UnionFind sets(vertex_count);
    for (const Triangle& t : triangles) {
        sets.join(t[0], t[1]);
        sets.join(t[0], t[2]);
    }
    std::vector<int> sizes(vertex_count, 0);
    for (const Triangle& t : triangles) ++sizes[sets.find(t[0])];
    std::erase_if(triangles, [&](const Triangle& t) { return sizes[sets.find(t[0])] < min_triangles; });
}

Topology count_topology(const SurfaceMesh& surface) {
    Topology topology;
    const HalfedgeMesh mesh = to_halfedges(surface);
    std::vector<bool> seen_face(mesh.n_faces(), false), seen_halfedge(mesh.n_halfedges(), false);
    std::vector<OpenMesh::FaceHandle> stack;
    for (const auto seed : mesh.faces()) {
        if (seen_face[seed.idx()]) continue;
        ++topology.components;
        seen_face[seed.idx()] = true;
        stack.assign(1, seed);
        while (!stack.empty()) {
            const auto face = stack.back();
            stack.pop_back();
            for (const auto neighbour : mesh.ff_range(face)) {
                if (seen_face[neighbour.idx()]) continue;
                seen_face[neighbour.idx()] = true;
                stack.push_back(neighbour);
            }
        }
    }
    for (const auto start : mesh.halfedges()) {
        if (!start.is_boundary() || seen_halfedge[start.idx()]) continue;
        ++topology.boundary_loops;
        auto h = start;
        do {
            seen_halfedge[h.idx()] = true;
            h = h.next();
        } while (h != start);
    }
    return topology;
}

}  // namespace hexrelief::stages
