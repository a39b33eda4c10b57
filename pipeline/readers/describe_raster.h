// Says what a raster file holds without decoding its samples.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "pipeline/readers/limits.h"

namespace hexrelief::readers {

struct FileDescription {
    std::string format;  // "png", "pgm", "ppm", "pfm", "jpeg", "tiff", "webp", "heic", "npy", "npz", "exr"
    int width = 0;
    int height = 0;
    int channels = 0;  // as stored, alpha included; a palette counts as its colours' channels
    int bits = 0;      // of one sample: 1, 2, 4, 8, 16, 32 or 64
    bool is_float = false;
};

// The header of an image or disparity map, of which no more than that is read (of NPZ and HEIC all),
// recognised by content; nullopt where the file is none of the formats above. Throws Error(input) where the
// file cannot be opened, or has the format's first bytes but a malformed header or more pixels than the
// limits allow.
std::optional<FileDescription> describe_raster(const std::filesystem::path& path, const std::string& key = {},
                                               const ReaderLimits& limits = {});

}  // namespace hexrelief::readers
