// Makes the files of maps that only pipeline/readers/depth reads.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tests/pipeline/readers/sample_files.h"

namespace hexrelief::readers {

// header: the dictionary's text; version 1.
Bytes make_npy(const std::string& header, const Bytes& samples, int version = 1);
// Of C order, little endian: "<f4", "|u1" and so on.
Bytes make_npy(const std::string& type, int width, int height, const Bytes& samples);

// Members of these names; packed by deflate or stored.
Bytes make_zip(const std::vector<std::pair<std::string, Bytes>>& members, bool deflated);

// A photograph whose depths are the fourth channel; the XMP packet is of the depths. Empty where libheif has
// no encoder. Only where libheif was found.
Bytes make_heic(int width, int height, const Bytes& rgb_and_depth, const std::string& xmp);
// The same file with representation information: 1 / Z between 0.5 and 4 m.
Bytes with_representation(Bytes heic);

struct ExrChannel {
    std::string name;
    std::vector<float> samples;
};
struct ExrKind {
    bool zip = false;  // each chunk packed by itself (ZIPS)
    int tile = 0;      // side of square tiles; 0 = lines
};
// Floats, the data window not at the origin; channels in the order of their names.
Bytes make_exr(int width, int height, const std::vector<ExrChannel>& channels, const ExrKind& kind = {});

}  // namespace hexrelief::readers
