// The time and memory that a device reports for its own work.
#pragma once

#include <cstddef>

namespace hexrelief {

// Seconds by the device's clock, without transfers, of the latest lattice and the latest cut; all 0 on the
// CPU.
struct DeviceFigures {
    double training_s = 0;
    double balance_s = 0;
    double surface_s = 0;   // cutting and fitting
    std::size_t bytes = 0;  // peak of the device's memory
};

}  // namespace hexrelief
