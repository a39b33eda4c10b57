// Triangles whose corners would move, eight side by side.
#pragma once

#include <cstdint>

#include "mesher/surface/fit/triangle_shape_step.h"
#include "pipeline/data/geometry.h"

namespace hexrelief {

// Tells those that stay sound whichever of their corners go, as nearly all do, from others.
class CornerLanes {
  public:
    static constexpr int kLanes = 8;

    bool full() const { return used_ == kLanes; }
    void add(std::uint32_t triangle, const Vec2f from[3], const Vec2f to[3]) {
        for (int k = 0; k < 3; ++k) {
            from_[2 * k][used_] = from[k].x, from_[2 * k + 1][used_] = from[k].y;
            to_[2 * k][used_] = to[k].x, to_[2 * k + 1][used_] = to[k].y;
        }
        triangles_[used_++] = triangle;
    }
    // Calls visit(triangle) for those added since the last time that would be thinner than `least` were one
    // of their corners to go, or several.
    template <typename Visit>
    void each_doubtful(double least, const Visit& visit) {
        double spare[kLanes];
        if (used_ > 0) find_spare(least, spare);
        for (int i = 0; i < used_; ++i)
            if (!(spare[i] > 0)) visit(triangles_[i]);
        used_ = 0;
    }

  private:
    // Of each lane, by how much it is no thinner at worst.
    void find_spare(double least, double* spare) const;

    int used_ = 0;
    std::uint32_t triangles_[kLanes];
    double from_[6][kLanes] = {}, to_[6][kLanes] = {};  // x and y of each corner
};

}  // namespace hexrelief
