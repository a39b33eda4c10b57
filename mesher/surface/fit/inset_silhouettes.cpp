#include "mesher/surface/fit/inset_silhouettes.h"

#include "mesher/surface/fit/inset_silhouettes_step.h"
#include "pipeline/base/thread_team.h"

namespace hexrelief::surface {

void inset_silhouettes(const PixelSurfaces& surfaces, const DisparityMap& map, double by_px,
                       const LatticeFans& fans, CutTriangles& cut, ThreadPool& pool) {
    const std::size_t points = cut.points.size();
    RawVector<unsigned> starts(points), ends(points);
    RawVector<std::uint32_t> corners(3 * cut.triangles.size());
    RawVector<Vec2f> targets(points);
    RawVector<std::uint8_t> moves(points);
    const step::InsetArrays arrays{
        {starts.data(), ends.data(), corners.data()}, targets.data(), moves.data()};
    ThreadTeam::run(pool, [&](ThreadTeam& team) {
        step::inset_silhouettes(team, surfaces.view(), map.values.data(), by_px, fans, cut.view(),
                                cut.points.data(), arrays);
    });
}

}  // namespace hexrelief::surface
