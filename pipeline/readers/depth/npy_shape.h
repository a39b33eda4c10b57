// The header of numpy's arrays, for archives of them.
#pragma once

#include <string>
#include <vector>

#include "pipeline/readers/source.h"

namespace hexrelief::readers::codec {

inline constexpr std::size_t kLongestNpyHeader = 1 << 16;

struct NpyShape {
    std::vector<unsigned long long> shape;
    std::string type;  // "float32", "bool"
};

// Reads the header of an array of any shape; the samples may be missing. Throws Error(input) if it is
// malformed, or its numbers are of another type than integers, floats and truth values.
NpyShape read_npy_shape(const SourceFile& source);

}  // namespace hexrelief::readers::codec
