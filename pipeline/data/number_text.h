// Numbers in messages.
#pragma once

#include <cstdio>
#include <string>

namespace hexrelief {

// As short as it was written: "6", "713.26". Nine digits at most.
inline std::string number_text(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.9g", value);
    return text;
}

}  // namespace hexrelief
