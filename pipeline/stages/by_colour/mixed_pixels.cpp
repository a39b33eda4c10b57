#include "pipeline/stages/by_colour/mixed_pixels.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "pipeline/base/thread_pool.h"
#include "pipeline/data/color_difference.h"
#include "pipeline/data/four_neighbours.h"

namespace hexrelief::stages {
namespace {

constexpr std::size_t kLeastSurface = 60;  // pixels of a surface of its own
constexpr std::size_t kScrapShare = 1700;  // of the picture: pixels of a scrap without matches, at most
constexpr int kStripShare = 200;           // of the longer side: the width of a strip without matches
constexpr int kRimShare = 450;             // of the longer side: the mixed pixels at a silhouette
constexpr float kHighStep = 2;             // of the rim's width
constexpr float kLargestStep_px = 1.0001f;

bool is_filled(const DisparityMap& map, std::size_t i) {
    return !map.origins.empty() && map.origins[i] == PixelOrigin::filled;
}

// Marks the pixels of small regions between nearer and farther ones, and of scraps.
void mark_regions(const DisparityMap& map, Scraps scraps, std::vector<std::uint8_t>& is_open) {
    const std::size_t count = map.values.size(), most = scraps == Scraps::go
                                                            ? std::max(kLeastSurface, count / kScrapShare)
                                                            : kLeastSurface;
    std::vector<std::uint8_t> is_seen(count);
    std::vector<std::size_t> region;
    // Regions that are not followed to their end are too large, and so is what meets a part of them.
    constexpr std::uint8_t kComplete = 1, kLarge = 2;
    const auto open = [&](std::size_t seed) {
        if (is_seen[seed] || !DisparityMap::known(map.values[seed])) return;
        is_seen[seed] = kComplete;
        region.assign(1, seed);
        bool has_nearer = false, is_large = false;
        std::size_t filled = 0;
        for (std::size_t next = 0; next < region.size() && region.size() < most && !is_large; ++next) {
            const float own = map.values[region[next]];
            filled += is_filled(map, region[next]);
            for_four_neighbours(region[next], map.width, map.height, [&](std::size_t i) {
                if (!DisparityMap::known(map.values[i])) return;
                const float step = map.values[i] - own;
                has_nearer |= step > kLargestStep_px;
                if (std::abs(step) > kLargestStep_px) return;
                is_large |= is_seen[i] == kLarge;
                if (is_seen[i]) return;
                is_seen[i] = kComplete;
                region.push_back(i);
            });
        }
        is_large |= region.size() >= most;
        const bool is_small = has_nearer && region.size() < kLeastSurface,
                   is_scrap = scraps == Scraps::go && 2 * filled > region.size();
        for (const std::size_t i : region)
            if (is_large)
                is_seen[i] = kLarge;
            else if (is_small || is_scrap)
                is_open[i] = 1;
    };
    const auto width = static_cast<std::size_t>(map.width);
    for (std::size_t i = 0; i < count; ++i)
        for (const std::size_t step : {std::size_t{1}, width}) {
            const std::size_t other = i + step;
            if (other >= count || (step == 1 && other % width == 0)) continue;
            if (map.values[i] - map.values[other] > kLargestStep_px) open(i);
            if (map.values[other] - map.values[i] > kLargestStep_px) open(other);
        }
}

// Marks the filled pixels of narrow runs along a row or a column that lie in front of both their ends.
void mark_strips(const DisparityMap& map, std::vector<std::uint8_t>& is_open) {
    const int widest = std::max(map.width, map.height) / kStripShare;
    const auto width = static_cast<std::size_t>(map.width);
    // From the pixel before the run; after: the pixels behind that one.
    const auto mark_run = [&](std::size_t before, std::size_t step, int after) {
        const auto fall = [&](std::size_t i) { return map.values[i] - map.values[i + step]; };
        if (!(fall(before) < -kLargestStep_px) || !DisparityMap::known(map.values[before + step])) return;
        const std::size_t begin = before + step;
        std::size_t last = begin;
        int length = 1;
        for (; length < after && length <= widest && std::abs(fall(last)) <= kLargestStep_px; ++length)
            last += step;
        if (length == after || length > widest || !(fall(last) > kLargestStep_px)) return;
        for (std::size_t i = begin; i <= last; i += step)
            if (is_filled(map, i)) is_open[i] = 1;
    };
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            const std::size_t i = y * width + x;
            if (x + 1 < map.width) mark_run(i, 1, map.width - 1 - x);
            if (y + 1 < map.height) mark_run(i, width, map.height - 1 - y);
        }
}

}  // namespace

DisparityMap without_mixed_pixels(DisparityMap map, const Image& left, Scraps scraps) {
    struct Open {
        std::size_t pixel;
        float value;
    };
    std::vector<std::uint8_t> is_open(map.values.size());
    mark_regions(map, scraps, is_open);
    mark_strips(map, is_open);
    std::vector<Open> open;
    for (std::size_t i = 0; i < is_open.size(); ++i)
        if (is_open[i]) open.push_back({i, map.values[i]});
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

DisparityMap with_wider_near(DisparityMap map, int threads) {
    constexpr float kNone = std::numeric_limits<float>::lowest();
    ThreadPool pool(threads);
    const int rounds = std::max(1, (std::max(map.width, map.height) + kRimShare / 2) / kRimShare);
    const float least_step = kHighStep * static_cast<float>(rounds);
    // With a border of one pixel; unknown pixels have kNone.
    const auto stride = static_cast<std::ptrdiff_t>(map.width) + 2;
    std::vector<float> now(static_cast<std::size_t>(stride) * (map.height + 2), kNone), next = now;
    const auto row_of = [&](std::vector<float>& values, int y) { return &values[stride * (y + 1) + 1]; };
    pool.parallel_for_each(map.height, [&](int y) {
        for (int x = 0; x < map.width; ++x)
            if (DisparityMap::known(map.at(x, y))) row_of(now, y)[x] = map.at(x, y);
    });
    // A pixel a round, every other round without the corners: an octagon.
    for (int round = 0; round < rounds; ++round) {
        const bool is_diagonal = round % 2 > 0;
        pool.parallel_for_each(map.height, [&](int y) {
            const float* const own = row_of(now, y);
            float* const out = row_of(next, y);
            for (int x = 0; x < map.width; ++x) {
                const float *const above = own + x - stride, *const below = own + x + stride;
                float nearest = std::max(std::max(own[x - 1], own[x + 1]), std::max(*above, *below));
                if (is_diagonal)
                    nearest = std::max(
                        nearest, std::max(std::max(above[-1], above[1]), std::max(below[-1], below[1])));
                out[x] = own[x] != kNone && nearest - own[x] > least_step ? nearest : own[x];
            }
        });
        now.swap(next);
    }
    pool.parallel_for_each(map.height, [&](int y) {
        for (int x = 0; x < map.width; ++x)
            if (DisparityMap::known(map.at(x, y))) map.at(x, y) = row_of(now, y)[x];
    });
    return map;
}

}  // namespace hexrelief::stages
