#include "mesher/surface/topology/cut_vertices.h"

#include "mesher/surface/topology/cut_vertices_step.h"
#include "pipeline/base/thread_team.h"

namespace hexrelief::surface {

LatticeFans fans_of(const SplitLattice& lattice, const TriangleLabels& labels) {
    return {lattice.triangles.data(), lattice.neighbours.data(), labels.open.data(), labels.kept.data()};
}

CutTriangles cut_vertices(const SplitLattice& lattice, const TriangleLabels& labels, ThreadPool& pool) {
    const std::size_t points = lattice.points.size(), triangles = lattice.triangles.size();
    RawVector<std::uint32_t> firsts(3 * triangles), next(3 * triangles), lists(points), fans(points),
        numbers(points), copies(3 * triangles), indices(triangles);
    const step::FanArrays arrays{firsts.data(),  next.data(),   lists.data(),  fans.data(),
                                 numbers.data(), copies.data(), indices.data()};
    const LatticeFans view = fans_of(lattice, labels);
    CutTriangles cut;
    ThreadTeam::run(pool, [&](ThreadTeam& team) {
        const step::VertexCutter cutter(team, view, static_cast<unsigned>(points),
                                        static_cast<unsigned>(triangles), labels.cuts.data(), arrays);
        const step::CutMeshSize size = cutter.number();
        if (team.is_first()) {
            cut.points.resize(size.points);
            cut.triangles.resize(size.triangles);
            cut.source_triangles.resize(size.triangles);
        }
        team.wait();
        cutter.write(lattice.points.data(),
                     {cut.points.data(), cut.triangles.data(), cut.source_triangles.data(), size.points});
    });
    return cut;
}

}  // namespace hexrelief::surface
