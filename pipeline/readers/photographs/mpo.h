// Multi-picture files: JPEG files one after the other. In MPO files the first has an index in APP2; in
// others, such as LIF, the second simply follows. JPS files are one JPEG with both views.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "pipeline/readers/source.h"

namespace hexrelief::readers::codec {

struct JpegPicture {
    std::size_t begin, size;  // in bytes; it lies inside the file
    const char* role;         // "view of a pair", "preview"
};
// Returns the pictures of a JPEG file behind the first one, at most 32, by its index or one after the other.
// An index that is malformed lists none.
std::vector<JpegPicture> list_further_pictures(const SourceFile& source);

struct SecondPicture {
    std::size_t begin, size;      // in bytes; it lies inside the file
    bool is_right_first = false;  // the index numbers the first picture as a view further to the right
};

// Returns a file's second view, by its index (CIPA DC-007), or without one the picture behind the end of the
// first. Previews in an index are passed over. Returns nullopt if the file is not a JPEG or holds one
// picture. Throws Error(input) if the index is malformed or lists no second view.
std::optional<SecondPicture> find_second_picture(const SourceFile& source);

// How a JPS file holds its views, by its APP3 segment "_JPSJPS_".
struct JpsLayout {
    bool is_top_bottom = false, is_half = false, is_left_first = false;
};
// Returns nullopt if the file has no such segment or its views are neither side by side nor one above the
// other.
std::optional<JpsLayout> find_jps_layout(const SourceFile& source);

}  // namespace hexrelief::readers::codec
