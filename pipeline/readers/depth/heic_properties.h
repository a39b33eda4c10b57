// The properties of a HEIC file's pictures (ISO/IEC 23008-12).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/readers/depth/iso_boxes.h"

namespace hexrelief::readers::codec {

// Calls visit(type, content) for each box inside the file's box "meta".
template <typename Visit>
void each_box_of_meta(Bytes file, const Visit& visit) {
    each_box(file, [&](std::string_view type, Bytes meta) {
        if (type != "meta") return;
        take(meta, 4);  // version and flags
        each_box(meta, visit);
    });
}

// Calls visit(number, type) for each item of the file; types are of four letters, as "hvc1" or "Exif".
template <typename Visit>
void each_item(Bytes file, const Visit& visit) {
    each_box_of_meta(file, [&](std::string_view type, Bytes list) {
        if (type != "iinf") return;
        const auto version = take(list, 4) >> 24;
        take(list, version == 0 ? 2 : 4);  // how many there are
        each_box(list, [&](std::string_view child, Bytes entry) {
            const auto entry_version = child == "infe" ? take(entry, 4) >> 24 : 0;
            if (entry_version < 2) return;
            const auto item = static_cast<std::uint32_t>(take(entry, entry_version == 2 ? 2 : 4));
            take(entry, 2);  // protection
            if (entry.size() >= 4)
                visit(item, std::string_view(reinterpret_cast<const char*>(entry.data()), 4));
        });
    });
}

// What a picture's properties tell of its size, its camera and its kind. Focal length and principal point are
// shares of the picture's width and height.
struct HeicView {
    int width = 0, height = 0;  // as stored
    double focal = 0, center_x = 0, center_y = 0;
    double position_m = 0;  // along x
    bool is_placed = false, is_turned = false;
    std::string_view auxiliary_type = {};  // URN of an auxiliary picture, in the file's bytes
};

// Returns the properties of the item with this number. Malformed properties count as missing.
HeicView heic_view(Bytes file, std::uint32_t item);

struct HeicPicture {
    int width = 0, height = 0;  // as stored; 0 = not said
    std::string role;           // "left view", "thumbnail"
};

// Returns the file's first 32 pictures, without those that are tiles of another. Malformed boxes count as
// missing.
std::vector<HeicPicture> list_heic_pictures(Bytes file);

}  // namespace hexrelief::readers::codec
