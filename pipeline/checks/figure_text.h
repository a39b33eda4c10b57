// Formats figures for warnings.
#pragma once

#include <cstdio>
#include <string>

namespace hexrelief::checks {

// Returns a number with three digits or more: 0.0123, 1.23, 1234.
inline std::string figure(double value) {
    char text[32];
    const double size = value < 0 ? -value : value;
    if (size >= 100)
        std::snprintf(text, sizeof text, "%.0f", value);
    else
        std::snprintf(text, sizeof text, "%.3g", value);
    return text;
}

inline std::string percent(double share) {
    char text[32];
    std::snprintf(text, sizeof text, "%.0f %%", 100 * share);
    return text;
}

}  // namespace hexrelief::checks
