// Makes the files of the map formats that only pipeline/readers/depth reads.
#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "tests/pipeline/readers/sample_files.h"

namespace hexrelief::readers {

// Makes an NPY file. header: the dictionary's text.
Bytes make_npy(const std::string& header, const Bytes& samples, int version = 1);
// Makes an NPY file in C order; type: "<f4", "|u1" and so on.
Bytes make_npy(const std::string& type, int width, int height, const Bytes& samples);

// Makes a ZIP archive of these members, deflated or stored.
Bytes make_zip(const std::vector<std::pair<std::string, Bytes>>& members, bool deflated);

// Makes a photograph whose depths are the fourth channel; the XMP packet belongs to the depths. Empty if
// libheif has no encoder. Only available if libheif was found.
Bytes make_heic(int width, int height, const Bytes& rgb_and_depth, const std::string& xmp,
                const Bytes& profile = {});
// Makes a spatial photograph of two pictures of one colour, 64x64 px. Empty as make_heic().
Bytes make_heic_pair(std::array<std::uint8_t, 3> left, std::array<std::uint8_t, 3> right);
// Returns the file with representation information: 1 / Z between 0.5 and 4 m.
Bytes with_representation(Bytes heic);

struct ExrChannel {
    std::string name;
    std::vector<float> samples;
};
struct ExrKind {
    bool zip = false;  // each chunk compressed by itself (ZIPS)
    int tile = 0;      // side of square tiles; 0 = scan lines
};
// Makes an EXR file of floats whose data window is not at the origin; channels are in the
// order of their names.
Bytes make_exr(int width, int height, const std::vector<ExrChannel>& channels, const ExrKind& kind = {});

struct ExrPart {
    std::string name;
    std::vector<ExrChannel> channels;
    std::array<int, 4> data, display;  // windows: least x and y, largest x and y
    bool half = false, lossy = false;  // DWAA instead of ZIP
};
// Makes an EXR file of these parts. Only available if OpenEXR was found.
Bytes make_exr_parts(const std::vector<ExrPart>& parts);

}  // namespace hexrelief::readers
