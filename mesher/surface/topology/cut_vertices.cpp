#include "mesher/surface/topology/cut_vertices.h"

#include "mesher/surface/topology/join_cuts_step.h"
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

void TriangleLabeler::join_cuts(const SplitLattice& lattice) {
    const std::size_t points = lattice.points.size(), triangles = lattice.triangles.size();
    labels_.cuts.resize(points);
    RawVector<std::uint64_t> next(points), after(points);
    RawVector<std::uint32_t> joins(3 * triangles);
    unsigned count = 0;
    const step::FanView view{lattice.triangles.data(), lattice.neighbours.data(), labels_.open.data(),
                             std::as_const(labels_).kept.data()};
    const step::CutArrays arrays{labels_.cuts.data(), {next.data(), after.data()}, joins.data(), &count};
    ThreadTeam::run(pool_, [&](ThreadTeam& team) {
        step::CutJoiner(team, view, arrays)
            .join(static_cast<unsigned>(points), static_cast<unsigned>(triangles));
    });
}

}  // namespace hexrelief::surface
