// The boxes of HEIC files (ISO/IEC 14496-12), and what they tell and libheif does not: the stereo pair, the
// pair's cameras, EXIF data, and properties of the pictures (ISO/IEC 23008-12).
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/data/calibration.h"
#include "pipeline/readers/source.h"

namespace hexrelief::readers::codec {

using Bytes = std::span<const std::uint8_t>;

// Removes a big-endian number from the front and returns it; bytes beyond the end count as 0.
inline std::uint64_t take(Bytes& bytes, int count) {
    std::uint64_t value = 0;
    for (int i = 0; i < count; ++i) {
        value = value << 8 | (bytes.empty() ? 0 : bytes.front());
        bytes = bytes.subspan(bytes.empty() ? 0 : 1);
    }
    return value;
}

// Calls visit(type, content) for each box. A box that claims to be longer than the rest ends with it.
template <typename Visit>
void each_box(Bytes bytes, const Visit& visit) {
    while (bytes.size() >= 8) {
        Bytes rest = bytes;
        std::uint64_t size = take(rest, 4);
        const std::string_view type(reinterpret_cast<const char*>(rest.data()), 4);
        rest = rest.subspan(4);
        if (size == 1) size = take(rest, 8);
        const std::uint64_t header = bytes.size() - rest.size();
        if (size == 0) size = bytes.size();
        size = std::clamp<std::uint64_t>(size, header, bytes.size());
        visit(type, bytes.subspan(header, size - header));
        bytes = bytes.subspan(size);
    }
}

// The first stereo pair group of a file (ISO/IEC 23008-12, 6.8.5).
struct HeicPair {
    std::uint32_t left = 0, right = 0;  // numbers of the pictures
    int width = 0, height = 0;          // of the left picture as stored; 0 = not said
    // Of the left picture: the focal length, the principal point, the difference of the two principal points
    // and the cameras' distance, by the properties cmin and cmex or Apple's older ones. 0 = not said.
    Calibration camera = {};
};

// Returns nullopt if the file has no such group. Malformed boxes count as missing.
std::optional<HeicPair> find_heic_pair(Bytes file);

// Returns the file's EXIF data, without the offset in front; empty if it has none.
std::vector<std::uint8_t> heic_exif(Bytes file);

// Throws Error(input) if item references (ISO/IEC 14496-12, 8.11.12) are nested more than 8 deep (phones use
// 3: tone map, grid, tile), or if a picture is put together from more than 16,384 others. libheif 1.15
// decodes nested pictures to any depth that the file asks for, and endlessly if one is derived from itself.
void check_derivations(const SourceFile& source);

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
