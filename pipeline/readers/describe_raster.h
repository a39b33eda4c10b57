// Describes a raster file without decoding its samples.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/readers/limits.h"

namespace hexrelief::readers {

struct FileDescription {
    std::string
        format;  // "png", "pgm", "ppm", "pfm", "jpeg", "tiff", "webp", "bmp", "heic", "npy", "npz", "exr"
    int width = 0;
    int height = 0;
    int channels = 0;  // as stored, alpha included; a palette counts as the channels of its colours
    int bits = 0;      // per sample: 1, 2, 4, 8, 16, 32 or 64
    bool is_float = false;
};

// Describes an image or disparity map, recognised by content, from its header (of NPZ and HEIC the whole
// file is read). Returns nullopt if the file has none of the formats above. Throws Error(input) if the file
// cannot be opened, or if it begins like one of the formats but its header is malformed or has more pixels
// than the limits allow.
std::optional<FileDescription> describe_raster(const std::filesystem::path& path, const std::string& key = {},
                                               const ReaderLimits& limits = {});

// Returns a line for each array of an NPZ file, or each part of an EXR file: names, types, sizes. Empty for
// other files. Throws Error(input) if the file is malformed.
std::vector<std::string> list_contents(const std::filesystem::path& path, const ReaderLimits& limits = {});

}  // namespace hexrelief::readers
