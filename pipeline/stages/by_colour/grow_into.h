// Surfaces that grow into pixels of a map that are to join them.
#pragma once

#include <cstddef>
#include <vector>

#include "pipeline/data/disparity_map.h"
#include "pipeline/data/four_neighbours.h"

namespace hexrelief::stages {

// Gives some pixels of a map, by a pixel a round, the mean of those of their four neighbours that are known
// and for which is_source(pixel, d, neighbour) holds; d is what the pixel had. joined(pixel) is called when a
// pixel has got its mean, after all of its round have been looked at. Pixels without a source stay.
template <class IsSource, class Joined>
void grow_into(DisparityMap& map, const std::vector<std::size_t>& pixels, const IsSource& is_source,
               const Joined& joined) {
    struct Open {
        std::size_t pixel;
        float value;
    };
    std::vector<Open> open, still, now;
    for (const std::size_t i : pixels) open.push_back({i, map.values[i]});
    do {
        still.clear();
        now.clear();
        for (const Open& o : open) {
            float sum = 0;
            int count = 0;
            for_four_neighbours(o.pixel, map.width, map.height, [&](std::size_t i) {
                if (!DisparityMap::known(map.values[i]) || !is_source(o.pixel, o.value, i)) return;
                sum += map.values[i];
                ++count;
            });
            if (count > 0)
                now.push_back({o.pixel, sum / static_cast<float>(count)});
            else
                still.push_back(o);
        }
        for (const Open& o : now) {
            map.values[o.pixel] = o.value;
            joined(o.pixel);
        }
        open.swap(still);
    } while (!now.empty());
}

}  // namespace hexrelief::stages
