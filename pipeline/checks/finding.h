// The kinds of mistakes that an input's meaning may reveal.
#pragma once

#include <string>

namespace hexrelief::checks {

enum class Mistake {
    views_equal,
    views_swapped,
    rows_differ,
    views_unrelated,
    no_texture,
    range_begins_high,
    range_ends_low,
    range_wide,
    values_are_depth,
    depths_are_inverse,
    values_are_colors,
    values_large,
    values_small,
    rows_flipped,  // against the picture
    color_mirrored,
    color_elsewhere,  // shifted against the map
    color_unrelated,
    baseline_in_mm,
    focal_in_mm,
    depth_implausible,
};

// A finding as one line: what was seen, with a figure, what it means, and what to do.
struct Finding {
    Mistake mistake;
    std::string text;
};

}  // namespace hexrelief::checks
