// The axis-aligned bounding box of points.
#pragma once

#include <algorithm>
#include <vector>

#include "pipeline/data/geometry.h"

namespace hexrelief {

struct Bounds {
    Vec3f low, high;

    void include(const Vec3f& p) {
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    float widest_side() const { return std::max({high.x - low.x, high.y - low.y, high.z - low.z}); }
};

// Returns the bounding box of `points`, of which there must be at least one.
inline Bounds bounds_of(const std::vector<Vec3f>& points) {
    Bounds bounds{points.front(), points.front()};
    for (const Vec3f& p : points) bounds.include(p);
    return bounds;
}

}  // namespace hexrelief
