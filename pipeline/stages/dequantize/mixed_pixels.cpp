#include "pipeline/stages/dequantize/mixed_pixels.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "pipeline/data/color_difference.h"
#include "pipeline/data/four_neighbours.h"

namespace hexrelief::stages {
namespace {

constexpr std::size_t kLeastSurface = 60;  // pixels of a surface of its own
constexpr float kLargestStep_px = 1.0001f;

// Returns the pixels of small regions between nearer and farther ones.
std::vector<std::size_t> find_mixed(const DisparityMap& map) {
    std::vector<std::size_t> mixed, region;
    std::vector<std::uint8_t> is_seen(map.values.size());
    for (std::size_t seed = 0; seed < is_seen.size(); ++seed) {
        if (is_seen[seed] || !DisparityMap::known(map.values[seed])) continue;
        is_seen[seed] = 1;
        region.assign(1, seed);
        bool has_nearer = false, has_farther = false;
        for (std::size_t next = 0; next < region.size(); ++next) {
            const float own = map.values[region[next]];
            for_four_neighbours(region[next], map.width, map.height, [&](std::size_t i) {
                if (!DisparityMap::known(map.values[i])) return;
                const float step = map.values[i] - own;
                has_nearer |= step > kLargestStep_px;
                has_farther |= step < -kLargestStep_px;
                if (is_seen[i] || std::abs(step) > kLargestStep_px) return;
                is_seen[i] = 1;
                region.push_back(i);
            });
        }
        if (region.size() < kLeastSurface && has_nearer && has_farther)
            mixed.insert(mixed.end(), region.begin(), region.end());
    }
    return mixed;
}

}  // namespace

DisparityMap without_mixed_pixels(DisparityMap map, const Image& left) {
    struct Open {
        std::size_t pixel;
        float value;
    };
    std::vector<Open> open;
    for (const std::size_t i : find_mixed(map)) open.push_back({i, map.values[i]});
    std::vector<std::uint8_t> is_open(map.values.size());
    for (const Open& o : open) is_open[o.pixel] = 1;
    // Surfaces grow by a pixel a round.
    for (std::size_t given = 1; given > 0;) {
        std::vector<Open> still, now;
        for (const Open& o : open) {
            int least = std::numeric_limits<int>::max();
            float value = o.value;
            for_four_neighbours(o.pixel, map.width, map.height, [&](std::size_t i) {
                if (is_open[i] || !DisparityMap::known(map.values[i])) return;
                const int here = color_difference(left, o.pixel, i);
                if (here >= least) return;
                least = here;
                value = map.values[i];
            });
            (least < std::numeric_limits<int>::max() ? now : still).push_back({o.pixel, value});
        }
        for (const Open& o : now) {
            map.values[o.pixel] = o.value;
            is_open[o.pixel] = 0;
        }
        given = now.size();
        open = std::move(still);
    }
    return map;
}

}  // namespace hexrelief::stages
