// Formats numbers for messages.
#pragma once

#include <cstdio>
#include <string>

namespace hexrelief {

// Returns the number with at most nine significant digits and no trailing zeros: "6", "713.26".
inline std::string number_text(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.9g", value);
    return text;
}

}  // namespace hexrelief
