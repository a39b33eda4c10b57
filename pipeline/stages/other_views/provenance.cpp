#include "pipeline/stages/other_views/provenance.h"

#include <algorithm>

namespace hexrelief::stages {
namespace {

constexpr double kNear_px = 1;  // of the border of a view: vertices on it are in the view

bool is_seen(const SeenSurface& seen, const ViewPoint& in_left) {
    const ViewPlace& place = seen.place;
    ViewPoint p = place.from_left(in_left);
    if (!(p.x > -kNear_px && p.x < place.width + kNear_px && p.y > -kNear_px &&
          p.y < place.height + kNear_px))
        return false;
    p.x = std::clamp(p.x, 0.5, place.width - 0.5);
    p.y = std::clamp(p.y, 0.5, place.height - 0.5);
    return seen.limit_around(place.to_left(p), 1) <= in_left.d + kOneSurface_px;
}

}  // namespace

std::vector<Provenance> provenance_of(const SurfaceMesh& mesh, const std::vector<SeenSurface>& seen,
                                      int threads) {
    std::vector<Provenance> result(mesh.image_points.size());
    for_row_bands(static_cast<int>(result.size()), threads, [&](int begin, int end) {
        for (int i = begin; i < end; ++i) {
            const ViewPoint point{mesh.image_points[i].x, mesh.image_points[i].y, mesh.disparities[i]};
            const bool by_left =
                           static_cast<std::size_t>(i) < mesh.left_vertices() || is_seen(seen[0], point),
                       by_right = seen.size() > 1 && is_seen(seen[1], point);
            result[i] = by_left && by_right ? Provenance::both
                        : by_left           ? Provenance::left
                        : by_right          ? Provenance::right
                                            : Provenance::nobody;
        }
    });
    return result;
}

}  // namespace hexrelief::stages
