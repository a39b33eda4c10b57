// The pictures inside of a HEIC file, told for people.
#pragma once

#include <string>
#include <vector>

#include "pipeline/readers/depth/iso_boxes.h"

namespace hexrelief::readers::codec {

struct HeicPicture {
    int width = 0, height = 0;  // as stored; 0 = not said
    std::string role;           // "left view", "thumbnail"
};

// Returns the file's first 32 pictures, without those that are tiles of another. Malformed boxes count as
// missing.
std::vector<HeicPicture> list_heic_pictures(Bytes file);

}  // namespace hexrelief::readers::codec
