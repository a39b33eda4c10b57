// Compares the disparities of the two views, and finds speckles. Disparities are in 1/16 px above min_px.
#pragma once

#include <cstdint>

#include "pipeline/base/host_device.h"
#include "pipeline/base/shared_memory_step.h"
#include "pipeline/matching/common/bordered_raster.h"
#include "pipeline/matching/refine/consistency.h"

namespace hexrelief::step {

// Returns the column of the right picture that a pixel of the left one matches.
HEXRELIEF_HD int matching_column(int x, int min_px, int disparity) {
    return x - min_px - ((disparity + matching::kOnePixel / 2) >> 4);
}

// Returns the column of the left picture that a pixel of the right one matches.
HEXRELIEF_HD int matching_left_column(int x, int min_px, int disparity) {
    return x + min_px + ((disparity + matching::kOnePixel / 2) >> 4);
}

// True if the match of a left pixel lies beyond the right picture's left edge, or less than half a px right
// of its first pixel: the right picture says nothing about such a pixel.
HEXRELIEF_HD bool beyond_left_edge(int x, int min_px, int disparity) {
    return matching::kOnePixel * (x - min_px) - disparity < matching::kOnePixel / 2;
}

// Returns the disparity of a pixel if `other`, the row of the other view, agrees
// at `column`; else kUnknown16.
HEXRELIEF_HD std::int16_t agreed(std::int16_t disparity, const std::int16_t* other, int column, int width,
                                 int limit) {
    if (disparity < 0 || column < 0 || column >= width) return matching::kUnknown16;
    const int difference = other[column] - disparity;
    return other[column] >= 0 && difference <= limit && difference >= -limit ? disparity
                                                                             : matching::kUnknown16;
}

// Returns the left view's disparity at a pixel if the right view's row agrees at its match, or if there is
// no check; else kUnknown16.
HEXRELIEF_HD std::int16_t checked_match(std::int16_t disparity, const std::int16_t* right_row, int x,
                                        int width, const matching::ConsistencyConfig& config) {
    if (config.left_right_limit < 0) return disparity;
    return agreed(disparity, right_row, matching_column(x, config.min_px, disparity), width,
                  config.left_right_limit);
}

// Returns the size up to which the patch of a pixel with this disparity is a speckle. False matches far
// beyond the scene form larger patches than others, and correct matches are rare there.
inline constexpr int kFarSpeckles = 4;
HEXRELIEF_HD int largest_speckle(const matching::ConsistencyConfig& config, std::int16_t disparity) {
    return disparity < config.least ? kFarSpeckles * config.speckle_pixels : config.speckle_pixels;
}

// True if two neighbours belong to the same patch.
HEXRELIEF_HD bool joined(std::int16_t a, std::int16_t b, int largest_step) {
    return a >= 0 && b >= 0 && a - b <= largest_step && b - a <= largest_step;
}

// The patches of a map with a border of kUnknown16, as sets of pixels numbered row by row. Each member
// function is called for all pixels, in any order and by many threads, before the next one.
struct Patches {
    static constexpr int kRun_px = 32;  // pixels of a row that start as one set

    matching::DisparityView map;
    matching::ConsistencyConfig config;
    unsigned *parents, *sizes;  // uninitialised, an entry per pixel

    HEXRELIEF_TEAM unsigned number(int x, int y) const {
        return static_cast<unsigned>(y) * static_cast<unsigned>(map.width) + static_cast<unsigned>(x);
    }
    HEXRELIEF_TEAM bool is_joined(int x, int y, int other_x, int other_y) const {
        return joined(map.at(x, y), map.at(other_x, other_y), config.speckle_step);
    }

    HEXRELIEF_TEAM void begin(int x, int y) const {
        const unsigned pixel = number(x, y);
        parents[pixel] = x % kRun_px > 0 && is_joined(x, y, x - 1, y) ? pixel - 1 : pixel;
        sizes[pixel] = 0;
    }
    HEXRELIEF_TEAM void join(int x, int y) const {
        const SharedSets sets{parents};
        if (x > 0 && x % kRun_px == 0 && is_joined(x, y, x - 1, y)) sets.join(number(x, y), number(x - 1, y));
        if (y == 0 || !is_joined(x, y, x, y - 1)) return;
        // One of two neighbours that are joined in both rows is enough.
        if (x > 0 && is_joined(x, y, x - 1, y) && is_joined(x, y - 1, x - 1, y - 1) &&
            is_joined(x - 1, y, x - 1, y - 1))
            return;
        sets.join(number(x, y), number(x, y - 1));
    }
    // Counts the pixels of a patch, until they are too many for any speckle.
    HEXRELIEF_TEAM void count(int x, int y) const {
        const unsigned root = SharedSets{parents}.root(number(x, y));
        if (load(sizes + root) <= static_cast<unsigned>(kFarSpeckles * config.speckle_pixels))
            add_to(sizes + root, 1);
    }
    HEXRELIEF_TEAM bool is_speckle(int x, int y) const {
        return sizes[SharedSets{parents}.root(number(x, y))] <=
               static_cast<unsigned>(largest_speckle(config, map.at(x, y)));
    }
};

// Returns the largest disparity that the right camera certainly sees at a column: the largest of three
// neighbouring pixels if all of them are matched; else kAnything.
inline constexpr int kAnything = INT16_MAX;
HEXRELIEF_HD std::int32_t nearest_seen(const std::int16_t* right_at) {
    const std::int16_t a = right_at[-1], b = right_at[0], c = right_at[1];
    if (a < 0 || b < 0 || c < 0) return kAnything;
    const std::int16_t larger = a > b ? a : b;
    return larger > c ? larger : c;
}
// True if a surface of this disparity would hide from the right camera the surface that
// it certainly sees there.
HEXRELIEF_HD bool hides(std::int32_t nearest, int disparity) {
    return nearest < disparity - matching::kOnePixel;
}
// True if the surface that the right camera certainly sees there is in front of a surface of this disparity.
HEXRELIEF_HD bool is_hidden(std::int32_t nearest, int disparity) {
    return nearest != kAnything && nearest > disparity + matching::kOnePixel;
}

// A pixel of the left picture, and the row of nearest_seen of the right one.
struct RowSite {
    int x, width, min_px;
    const std::int32_t* nearest_seen;
};

}  // namespace hexrelief::step
