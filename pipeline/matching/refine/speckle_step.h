// Finds speckles: small patches of neighbours whose disparities differ little.
#pragma once

#include <cstddef>

#include "pipeline/base/shared_memory_step.h"
#include "pipeline/matching/refine/consistency_step.h"

namespace hexrelief::step {

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

}  // namespace hexrelief::step
