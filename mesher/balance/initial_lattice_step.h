// Start positions of a lattice that will be balanced: columns of equal mass and rows of equal mass. They
// balance a density that is a product of one factor per column and one per row, such as a step or a ramp
// along an axis; training and balancing do the rest.
#pragma once

#include <cstdint>

#include "mesher/som/outline_step.h"
#include "pipeline/base/host_device.h"

namespace hexrelief::step {

// One part in kEvenPart of the mass is spread evenly over the columns (rows), so that empty
// ones keep some width.
inline constexpr int kEvenPart = 5;

// Returns the mass that is added to each of `count` columns (rows).
HEXRELIEF_HD std::int64_t even_mass(std::int64_t total, int count) {
    return total / kEvenPart / count;
}

// Returns the position along an axis of `count` px, at most `extent`, below which `share` of the mass lies.
// sums[k] is the mass of the first k columns (rows): count + 1 entries, strictly increasing.
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

// Moves such a start position between the upper and lower border of the lattice, if these are bent.
HEXRELIEF_HD void bend_start(const Border& border, int column, int row, float& x, float& y) {
    if (!is_bent(border.outline)) return;
    pin_to_border({border.lattice, {}, border.width, border.height}, column, row, x, y);
    y = y_of_share(border.outline, x, y / border.height);
}

}  // namespace hexrelief::step
