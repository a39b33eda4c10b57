// Order statistics of a few numbers.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace hexrelief::alignment {

// Returns the value below which this share of the values lies, 0 to 1; 0 if there are none.
inline double quantile(std::vector<double> values, double share) {
    if (values.empty()) return 0;
    const auto place = static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5);
    const auto nth = values.begin() + static_cast<std::ptrdiff_t>(place);
    std::nth_element(values.begin(), nth, values.end());
    return *nth;
}

inline double median(std::vector<double> values) {
    return quantile(std::move(values), 0.5);
}

}  // namespace hexrelief::alignment
