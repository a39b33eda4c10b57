// Balancing: the level's density as integers, so that its row sums are exact in any order.
#pragma once

#include <cstdint>

#include "mesher/balance/edge_integrals_step.h"

namespace hexrelief::step {

// bits of the densest pixel's mass; sums of 2^29 pixels fit into 64 bits
inline constexpr int kMassBits = 30;

// Returns the scale for whole_mass() on a level whose densest pixel holds `largest` > 0.
HEXRELIEF_HD double mass_scale(float largest) {
    return static_cast<double>(1 << kMassBits) / static_cast<double>(largest);
}

// Returns a pixel's density as an integer mass.
HEXRELIEF_HD std::int64_t whole_mass(float density, double scale) {
    return static_cast<std::int64_t>(static_cast<double>(density) * scale);
}

// Sets the units of a level with `total` > 0 mass in `filled` pixels, so that every cell's weight is 1 at
// perfect balance and empty pixels have floor_share of the filled pixels' mean.
HEXRELIEF_HD void set_units(BalanceView& v, std::int64_t total, std::int64_t filled, double floor_share) {
    const double mass = static_cast<double>(total);
    v.unit = (v.lattice.columns - 1.0) * (v.lattice.rows - 1.0) / (3 * mass);
    v.floor = static_cast<float>(floor_share * mass / static_cast<double>(filled) * v.unit);
}

}  // namespace hexrelief::step
