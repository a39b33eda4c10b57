#include "mesher/surface/topology/join_cuts_step.h"

#include "mesher/surface/topology/label_triangles.h"
#include "pipeline/base/thread_team.h"

namespace hexrelief::surface {

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
