#include "pipeline/stages/other_views/bridges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <cstdint>
#include <vector>

#include "pipeline/base/opencv_squares.h"
#include "pipeline/data/union_find.h"
#include "pipeline/stages/other_views/small_regions.h"

namespace hexrelief::stages {
namespace {

constexpr int kStride_px = 4;      // bridges lead through every fourth pixel of every fourth row
constexpr int kHalfBridge_px = 4;  // and have so many pixels around
constexpr int kClear = 2;  // stops around a bridge without an end of the surface: triangles are wider than it
constexpr double kMostFarther_px = 2;  // what is farther by more there is such an end
constexpr std::uint32_t kNoRegion = ~std::uint32_t{0};

// The regions of a map, with their sizes by the pixels that name them.
struct Regions {
    UnionFind sets;
    std::vector<std::size_t> sizes;

    Regions(const DisparityMap& map, double step_px) : sets(map.values.size()), sizes(map.values.size()) {
        const auto width = static_cast<std::uint32_t>(map.width);
        for (std::uint32_t i = 0; i < sizes.size(); ++i) {
            if (!DisparityMap::known(map.values[i])) continue;
            const auto join_to = [&](std::uint32_t beside) {
                if (std::abs(map.values[i] - map.values[beside]) <= step_px) sets.join(i, beside);
            };
            if (i >= width) join_to(i - width);
            if (i % width > 0) join_to(i - 1);
        }
        for (std::uint32_t i = 0; i < sizes.size(); ++i)
            if (DisparityMap::known(map.values[i])) ++sizes[sets.find(i)];
    }
    // Joins the regions of two pixels, if they are two and one is smaller than `least`. Returns whether.
    bool join(std::uint32_t a, std::uint32_t b, std::size_t least) {
        a = sets.find(a);
        b = sets.find(b);
        if (a == b || std::min(sizes[a], sizes[b]) >= least) return false;
        sets.join(a, b);
        sizes[std::min(a, b)] = sizes[a] + sizes[b];
        return true;
    }
};

// A pixel on the way from a region.
struct Stop {
    std::uint32_t pixel, region, from;  // from: the stop before; at the beginning the stop itself
    std::uint32_t colour_of;            // the pixel at the beginning
    int length;                         // stops from the region
};

// Neighbouring stops on the ways from two regions.
struct Meeting {
    int length;
    std::uint32_t stop, other;
    auto operator<=>(const Meeting&) const = default;
};

// The ways from all regions, with the disparities of their stops.
struct Ways {
    DisparityMap coarse;
    std::vector<Stop> stops;
    std::vector<Meeting> meetings;  // the shortest first
};

Ways ways_from(Regions& regions, const DisparityMap& map, const SeenSurface& here, int reach_px, bool below) {
    Ways ways{{map.width / kStride_px, map.height / kStride_px, {}}, {}, {}};
    std::vector<double> farthest;
    std::vector<std::uint32_t> reached;
    for (int y = 0; y < ways.coarse.height; ++y)
        for (int x = 0; x < ways.coarse.width; ++x) {
            const auto pixel = static_cast<std::uint32_t>((y * kStride_px + kStride_px / 2) * map.width +
                                                          x * kStride_px + kStride_px / 2);
            const auto stop = static_cast<std::uint32_t>(ways.stops.size());
            const bool is_known = DisparityMap::known(map.values[pixel]);
            farthest.push_back(here.disparities[pixel]);
            ways.coarse.values.push_back(is_known ? map.values[pixel] : static_cast<float>(farthest.back()));
            ways.stops.push_back({pixel, is_known ? regions.sets.find(pixel) : kNoRegion, stop, pixel, 0});
            if (is_known) reached.push_back(stop);
        }
    if (reached.empty()) return ways;
    take_least(farthest, ways.coarse.width, ways.coarse.height, kClear);
    for (std::size_t next = 0; next < reached.size(); ++next) {
        const Stop stop = ways.stops[reached[next]];
        const float d = ways.coarse.values[reached[next]];
        for_neighbours(ways.coarse, reached[next], [&](std::uint32_t i) {
            Stop& beside = ways.stops[i];
            float& beside_d = ways.coarse.values[i];
            const bool is_one = std::abs(beside_d - d) <= kOneSurface_px;
            if (beside.region != kNoRegion) {
                if (is_one && beside.region != stop.region)
                    ways.meetings.push_back({stop.length + beside.length, reached[next], i});
            } else if (stop.length * kStride_px < reach_px && farthest[i] >= d - kMostFarther_px &&
                       (is_one || (below && beside_d > d))) {
                beside = {beside.pixel, stop.region, reached[next], stop.colour_of, stop.length + 1};
                if (!is_one) beside_d = d;
                reached.push_back(i);
            }
        });
    }
    std::sort(ways.meetings.begin(), ways.meetings.end());
    return ways;
}

// Builds a bridge around a stop of this disparity.
void build_around(const Stop& stop, float d, DisparityMap& map, const SeenSurface& here, Regions& regions,
                  std::vector<BridgePixel>& bridges) {
    const auto width = static_cast<std::uint32_t>(map.width);
    const int x = static_cast<int>(stop.pixel % width), y = static_cast<int>(stop.pixel / width);
    for (int v = std::max(0, y - kHalfBridge_px); v <= std::min(map.height - 1, y + kHalfBridge_px); ++v)
        for (int u = std::max(0, x - kHalfBridge_px); u <= std::min(map.width - 1, x + kHalfBridge_px); ++u) {
            const std::uint32_t i = static_cast<std::uint32_t>(v) * width + u;
            const double front = here.disparities[i];
            if (DisparityMap::known(map.values[i]) || !(front >= d - kOneSurface_px)) continue;
            map.values[i] = front > d + kOneSurface_px ? d : static_cast<float>(front);
            regions.join(i, stop.region, 1);
            bridges.push_back({i, stop.colour_of});
        }
}

}  // namespace

std::vector<BridgePixel> join_regions(DisparityMap& missing, const SeenSurface& here, std::size_t least,
                                      int reach_px, double step_px) {
    std::vector<BridgePixel> bridges;
    Regions regions(missing, step_px);
    for (const bool below : {false, true}) {
        const Ways ways = ways_from(regions, missing, here, reach_px, below);
        for (const Meeting& meeting : ways.meetings) {
            if (!regions.join(ways.stops[meeting.stop].region, ways.stops[meeting.other].region, least))
                continue;
            for (std::uint32_t stop : {meeting.stop, meeting.other})
                for (bool is_first = false; !is_first; stop = ways.stops[stop].from) {
                    is_first = ways.stops[stop].from == stop;
                    build_around(ways.stops[stop], ways.coarse.values[stop], missing, here, regions, bridges);
                }
        }
    }
    return bridges;
}

void paint_bridges(OtherView& view, const std::vector<BridgePixel>& bridges) {
    Image& texture = view.picture.empty() ? view.color : view.picture;
    if (texture.empty()) return;
    const auto width = static_cast<std::uint32_t>(view.place.width);
    const auto column = [&](std::uint32_t x) { return static_cast<int>(x * texture.width / width); };
    const auto row = [&](std::uint32_t y) {
        return static_cast<int>(y * texture.height / view.place.height);
    };
    for (const auto& [pixel, colour_of] : bridges) {
        std::array<std::uint8_t, 3> colour = {};
        std::copy_n(texture.at(column(colour_of % width), row(colour_of / width)), texture.channels,
                    colour.data());
        // A smaller texture has no texel for most pixels.
        const std::uint32_t x = pixel % width, y = pixel / width;
        for (int r = row(y); r < row(y + 1); ++r)
            for (int c = column(x); c < column(x + 1); ++c)
                std::copy_n(colour.data(), texture.channels, texture.at(c, r));
    }
}

}  // namespace hexrelief::stages
