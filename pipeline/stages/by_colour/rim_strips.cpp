#include "pipeline/stages/by_colour/rim_strips.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "pipeline/data/four_neighbours.h"
#include "pipeline/data/line_of_map.h"
#include "pipeline/stages/by_colour/grow_into.h"

namespace hexrelief::stages {
namespace {

constexpr int kRimStripShare = 120;                               // of the longer side: the width
constexpr float kSilhouetteShare = 225, kLeastSilhouette_px = 2;  // of the longer side: a step; at least
constexpr float kRiseShare = 450;  // of the longer side: what the steps before it are worth
constexpr int kRounds = 2;         // a strip's corner is a strip when its sides have joined
constexpr float kJoinedStep_px = 1.0001f;

// Notes how far the strips of a line that end at a silhouette have to rise.
void find_rim_strips(const DisparityMap& map, const LineOfMap& line, std::vector<float>& rises) {
    const int longer = std::max(map.width, map.height), widest = std::max(2, longer / kRimStripShare);
    const float high_px = std::max(kLeastSilhouette_px, static_cast<float>(longer) / kSilhouetteShare);
    const auto at = [&](int i) { return map.values[line(i)]; };
    for (int end = 1; end + 1 < line.count; ++end) {
        const float fall = at(end) - at(end + 1);
        if (!(fall > high_px) || !DisparityMap::known(at(end)) || !DisparityMap::known(at(end + 1))) continue;
        int first = end + 1;
        for (int i = end; i > 0 && i > end - widest; --i) {
            const float rise = at(i - 1) - at(i);
            if (!(rise >= -kJoinedStep_px && at(i - 1) - at(end) <= fall)) break;
            if (rise > kJoinedStep_px) first = i;
        }
        for (int i = first; i <= end; ++i) rises[line(i)] = std::max(rises[line(i)], at(first - 1) - at(i));
    }
}

// Drops connected strips that nowhere have to rise by more than a share of the picture.
void drop_low_strips(const DisparityMap& map, std::vector<float>& rises) {
    const float low_px = static_cast<float>(std::max(map.width, map.height)) / kRiseShare;
    std::vector<bool> is_seen(rises.size());
    std::vector<std::size_t> strip;
    const auto add = [&](std::size_t i) {
        if (!(rises[i] > 0) || is_seen[i]) return;
        is_seen[i] = true;
        strip.push_back(i);
    };
    for (std::size_t seed = 0; seed < rises.size(); ++seed) {
        strip.clear();
        add(seed);
        float highest_px = 0;
        for (std::size_t next = 0; next < strip.size(); ++next) {
            highest_px = std::max(highest_px, rises[strip[next]]);
            for_four_neighbours(strip[next], map.width, map.height, add);
        }
        if (highest_px <= low_px)
            for (const std::size_t i : strip) rises[i] = 0;
    }
}

void join_rim_strips(DisparityMap& map) {
    std::vector<float> rises(map.values.size());  // 0 = no strip
    const std::ptrdiff_t width = map.width, last_row = width * (map.height - 1);
    for (std::ptrdiff_t row = 0; row <= last_row; row += width) {
        find_rim_strips(map, {row, 1, map.width}, rises);
        find_rim_strips(map, {row + width - 1, -1, map.width}, rises);
    }
    for (std::ptrdiff_t x = 0; x < width; ++x) {
        find_rim_strips(map, {x, width, map.height}, rises);
        find_rim_strips(map, {last_row + x, -width, map.height}, rises);
    }
    drop_low_strips(map, rises);
    std::vector<std::size_t> strips;
    for (std::size_t i = 0; i < rises.size(); ++i)
        if (rises[i] > 0) strips.push_back(i);
    const auto is_nearer = [&](std::size_t, float d, std::size_t i) {
        return !(rises[i] > 0) && map.values[i] > d;
    };
    grow_into(map, strips, is_nearer, [&](std::size_t i) { rises[i] = 0; });
}

}  // namespace

DisparityMap with_rim_strips_joined(DisparityMap map) {
    for (int round = 0; round < kRounds; ++round) join_rim_strips(map);
    return map;
}

}  // namespace hexrelief::stages
