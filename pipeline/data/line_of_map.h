// Lines of a map, for what goes along rows and columns in both directions.
#pragma once

#include <cstddef>

namespace hexrelief {

// The pixels of a row or a column, from either end.
struct LineOfMap {
    std::ptrdiff_t first, step;
    int count;
    std::size_t operator()(int i) const { return static_cast<std::size_t>(first + i * step); }
};

}  // namespace hexrelief
