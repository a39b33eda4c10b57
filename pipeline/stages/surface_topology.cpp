#include "pipeline/stages/surface_topology.h"

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <numeric>
#include <stdexcept>

namespace hexrelief {
namespace {

// Disjoint sets; the root is always the smallest member, so that the outcome does not depend on the order of
// joins.
class DisjointSets {
  public:
    explicit DisjointSets(std::size_t count) : parents_(count) {
        std::iota(parents_.begin(), parents_.end(), std::uint32_t{0});
    }
    std::uint32_t find(std::uint32_t i) {
        while (parents_[i] != i) i = parents_[i] = parents_[parents_[i]];
        return i;
    }
    void join(std::uint32_t a, std::uint32_t b) {
        a = find(a);
        b = find(b);
        if (a < b) parents_[b] = a;
        if (b < a) parents_[a] = b;
    }

  private:
    std::vector<std::uint32_t> parents_;
};

// Triangle corners sorted by vertex: corners of vertex v are items[starts[v]] .. items[starts[v + 1]).
struct CornerTable {
    std::vector<std::uint32_t> starts;
    std::vector<std::uint32_t> items;  // 3 * triangle + corner, ascending within a vertex
};

CornerTable corners_by_vertex(const std::vector<Triangle>& triangles, std::size_t vertex_count) {
    CornerTable table;
    table.starts.assign(vertex_count + 1, 0);
    for (const Triangle& triangle : triangles) {
        for (const std::uint32_t v : triangle) ++table.starts[v + 1];
    }
    std::partial_sum(table.starts.begin(), table.starts.end(), table.starts.begin());
    table.items.resize(3 * triangles.size());
    std::vector<std::uint32_t> next(table.starts.begin(), table.starts.end() - 1);
    for (std::uint32_t i = 0; i < table.items.size(); ++i) table.items[next[triangles[i / 3][i % 3]]++] = i;
    return table;
}

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
        if (!mesh.add_face(vertex(t[0]), vertex(t[1]), vertex(t[2])).is_valid()) {
            throw std::logic_error("surface: a triangle does not fit a manifold");
        }
    }
    return mesh;
}

}  // namespace

std::vector<std::uint32_t> split_fans(std::vector<Triangle>& triangles, std::size_t vertex_count) {
    const CornerTable table = corners_by_vertex(triangles, vertex_count);
    DisjointSets fans(table.items.size());  // of corners
    std::vector<std::uint32_t> origins, fan_vertex(table.items.size());
    std::vector<std::uint32_t> outgoing, incoming;  // neighbours of a corner's vertex in its triangle
    for (std::uint32_t v = 0; v < vertex_count; ++v) {
        outgoing.clear();
        incoming.clear();
        const std::uint32_t* const corners = table.items.data() + table.starts[v];
        const std::size_t count = table.starts[v + 1] - table.starts[v];
        for (std::size_t a = 0; a < count; ++a) {
            const Triangle& t = triangles[corners[a] / 3];
            outgoing.push_back(t[(corners[a] % 3 + 1) % 3]);
            incoming.push_back(t[(corners[a] % 3 + 2) % 3]);
        }
        // Two corners of v share an edge at v where one's outgoing neighbour is the other's incoming one.
        for (std::size_t a = 0; a < count; ++a)
            for (std::size_t b = 0; b < count; ++b)
                if (incoming[b] == outgoing[a]) fans.join(corners[a], corners[b]);
        for (std::size_t a = 0; a < count; ++a) {
            if (fans.find(corners[a]) != corners[a]) continue;  // the root is the fan's first corner
            fan_vertex[corners[a]] = static_cast<std::uint32_t>(origins.size());
            origins.push_back(v);
        }
    }
    for (std::uint32_t i = 0; i < table.items.size(); ++i) triangles[i / 3][i % 3] = fan_vertex[fans.find(i)];
    return origins;
}

void drop_small_components(std::vector<Triangle>& triangles, std::size_t vertex_count, int min_triangles) {
    if (min_triangles <= 1) return;
    // After split_fans() triangles that share a vertex are connected by edges, so vertices stand for
    // components.
    DisjointSets sets(vertex_count);
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

}  // namespace hexrelief
