// Multi-picture files (MPO): JPEG files one after the other, of which the first has an index in APP2.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <utility>

#include "pipeline/readers/source.h"

namespace hexrelief::readers::codec {

// Where the index (CIPA DC-007) has a file's second picture: its first byte and the number of bytes, which
// lie inside of the file. nullopt where the file is no JPEG or has no index. Throws Error(input) where the
// index has no second picture, or is malformed.
std::optional<std::pair<std::size_t, std::size_t>> find_second_picture(const SourceFile& source);

}  // namespace hexrelief::readers::codec
