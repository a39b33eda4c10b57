// First positions of a lattice that will be balanced: columns of equal mass and rows of equal mass, a step or
// a ramp along an axis solved at once. What is not made of such a product, training and balancing find.
#pragma once

#include <cstdint>

#include "mesher/common/host_device.h"
#include "mesher/som/outline_step.h"

namespace hexrelief::step {

// One part in so many of the mass is spread evenly, so that empty columns keep some width.
inline constexpr int kEvenPart = 5;

// What is added to each of `count` columns (rows) of the mass.
HEXRELIEF_HD std::int64_t even_mass(std::int64_t total, int count) {
    return total / kEvenPart / count;
}

// Position in a direction of `count` px, at most `extent`, up to which lies `share` of the mass; sums: of the
// first k columns (rows), count + 1 entries, strictly rising.
HEXRELIEF_HD float equalised(const std::int64_t* sums, int count, float share, float extent) {
    const double at = static_cast<double>(share) * static_cast<double>(sums[count]);
    int below = 0, above = count;
    while (above - below > 1) {
        const int middle = (below + above) / 2;
        if (static_cast<double>(sums[middle]) <= at)
            below = middle;
        else
            above = middle;
    }
    const double from = static_cast<double>(sums[below]), to = static_cast<double>(sums[above]);
    const float position = static_cast<float>(below + (at - from) / (to - from));
    return clamp_to(position, 0.0f, extent);
}

// Bends such a position with the ends of the lattice, whose sides already lie on those of the area.
HEXRELIEF_HD void bend_start(const Lattice& lattice, const Outline& outline, int column, int row, float width,
                             float height, float& x, float& y) {
    if (!is_bent(outline)) return;
    pin_to_border(lattice, {}, column, row, width, height, x, y);
    y = y_of_share(outline, x, y / height);
}

}  // namespace hexrelief::step
