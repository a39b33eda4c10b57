// What the boxes of a HEIC file tell and libheif does not: its stereo pair, the pair's cameras, its EXIF
// data.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "pipeline/data/calibration.h"
#include "pipeline/readers/depth/iso_boxes.h"
#include "pipeline/readers/source.h"

namespace hexrelief::readers::codec {

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

}  // namespace hexrelief::readers::codec
