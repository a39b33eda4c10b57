// Ranges of parameters, and their check.
#pragma once

#include <initializer_list>
#include <string>

#include "pipeline/data/number_text.h"

namespace hexrelief {

struct ValueRange {
    double min = 0, max = 0;  // inclusive

    constexpr bool holds(double value) const { return value >= min && value <= max; }  // false for NaN
};

struct RangedValue {
    template <typename Number>
    RangedValue(const char* name, Number number, ValueRange allowed)
        : key(name), value(static_cast<double>(number)), range(allowed) {}

    const char* key;
    double value;
    ValueRange range;
};

// Returns "density.floor must be from 0 to 1, not 2" for the first value outside its range; empty = none.
inline std::string out_of_range(std::initializer_list<RangedValue> values) {
    for (const auto& [key, value, range] : values)
        if (!range.holds(value))
            return std::string(key) + " must be from " + number_text(range.min) + " to " +
                   number_text(range.max) + ", not " + number_text(value);
    return {};
}

}  // namespace hexrelief
