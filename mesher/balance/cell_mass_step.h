// Balancing: the level's density as integers, so that its sums along rows are exact in any order.
#pragma once

#include <cstdint>

#include "mesher/balance/edge_integrals_step.h"

namespace hexrelief::step {

inline constexpr int kMassBits = 30;  // of the densest pixel; sums of 2^29 pixels fit 64 bits

// Factor of whole_mass for a level whose densest pixel holds `largest` > 0.
HEXRELIEF_HD double mass_scale(float largest) {
    return static_cast<double>(1 << kMassBits) / static_cast<double>(largest);
}

HEXRELIEF_HD std::int64_t whole_mass(float density, double scale) {
    return static_cast<std::int64_t>(static_cast<double>(density) * scale);
}

// Sets the units of a level with `total` > 0 mass in `filled` pixels such that a cell's weight is 1 at
// perfect balance and empty pixels have floor_share of the filled pixels' mean.
HEXRELIEF_HD void set_units(BalanceView& v, std::int64_t total, std::int64_t filled, double floor_share) {
    const double mass = static_cast<double>(total);
    v.unit = (v.lattice.columns - 1.0) * (v.lattice.rows - 1.0) / (3 * mass);
    v.floor = static_cast<float>(floor_share * mass / static_cast<double>(filled) * v.unit);
}

}  // namespace hexrelief::step
