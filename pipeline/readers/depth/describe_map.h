// What a map's file holds, and what a run would take it for.
#pragma once

#include <filesystem>
#include <string>

#include "pipeline/readers/limits.h"

namespace hexrelief::readers {

struct MapDescription {
    // Of the samples as stored that are finite and above 0, and are not the format's own for "not known".
    double least = 0, largest = 0;
    double known_share = 0;
    // By default: "16-bit integers, mm: 0.52 .. 7.31 m, 93.1 % known", or why the file is refused as such.
    std::string as_depth, as_disparity;
    bool may_be_mask = false;  // integers of at most one value besides 0
};

// `key` names the array of an NPZ or the channel of an EXR. Throws Error(input) as read_disparity_map() does
// for what is no map at all.
MapDescription describe_map(const std::filesystem::path& path, const std::string& key,
                            const ReaderLimits& limits = {});

}  // namespace hexrelief::readers
