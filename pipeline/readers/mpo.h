// Multi-picture files: JPEG files one after the other. In MPO files the first has an index in APP2; in
// others, such as LIF, the second simply follows.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <utility>

#include "pipeline/readers/source.h"

namespace hexrelief::readers::codec {

// Returns the first byte and the number of bytes of a file's second picture, by its index (CIPA DC-007), or
// without one behind the end of the first picture; both lie inside the file. Returns nullopt if the file is
// not a JPEG or holds one picture. Throws Error(input) if the index is malformed or lists no second picture.
std::optional<std::pair<std::size_t, std::size_t>> find_second_picture(const SourceFile& source);

}  // namespace hexrelief::readers::codec
