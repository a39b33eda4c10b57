// Describes a map's file, and how a run would interpret it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/readers/limits.h"

namespace hexrelief::readers {

struct MapDescription {
    // Over the stored samples that are finite, not 0 and not the format's own value for "unknown".
    double least = 0, largest = 0;
    double known_share = 0;
    // First the interpretation without options: "16-bit integers, mm: 0.52 .. 7.31 m, 93.1 % known", or why
    // the file is refused. Then those of usual options that give usual depths or disparities:
    // "--depth-unit 5000: 0.104 .. 1.46 m, 93.1 % known".
    std::vector<std::string> as_depth, as_disparity;
    bool may_be_mask = false;  // integers with at most one value besides 0
};

// Describes a map. `key` names the array of an NPZ or the channel of an EXR. Throws Error(input) as
// read_disparity_map() does if the file is not a map at all.
MapDescription describe_map(const std::filesystem::path& path, const std::string& key,
                            const ReaderLimits& limits = {});

}  // namespace hexrelief::readers
