#include "pipeline/stages/densify/measurements.h"

#include <algorithm>
#include <numeric>

#include "pipeline/base/opencv_squares.h"

namespace hexrelief::stages {
namespace {

constexpr std::uint32_t kStraight = kDistanceOne, kDiagonal = 23, kFar = 0x7fffffffu;
constexpr std::uint32_t kColor = kDistanceOne;  // cost of a colour step of 1

struct Sweep {
    int width, height;
    const Image& left;
    NearestMeasurements& nearest;

    std::size_t at(int x, int y) const { return static_cast<std::size_t>(y) * width + x; }

    void relax(int x, int y, int from_x, int from_y, std::uint32_t length) {
        if (from_x < 0 || from_x >= width || from_y < 0 || from_y >= height) return;
        const std::size_t own = at(x, y), from = at(from_x, from_y);
        std::uint32_t way = nearest.distance[from] + length;
        if (way >= nearest.distance[own]) return;
        if (!left.empty())
            way += kColor * static_cast<std::uint32_t>(
                                color_step(left.at(x, y), left.at(from_x, from_y), left.channels));
        if (way >= nearest.distance[own]) return;
        nearest.distance[own] = way;
        nearest.index[own] = nearest.index[from];
    }
    void downwards() {
        for (int y = 0; y < height; ++y) {
            for (int x = 0; x < width; ++x) {
                relax(x, y, x - 1, y - 1, kDiagonal);
                relax(x, y, x, y - 1, kStraight);
                relax(x, y, x + 1, y - 1, kDiagonal);
                relax(x, y, x - 1, y, kStraight);
            }
            for (int x = width - 2; x >= 0; --x) relax(x, y, x + 1, y, kStraight);
        }
    }
    void upwards() {
        for (int y = height - 1; y >= 0; --y) {
            for (int x = width - 1; x >= 0; --x) {
                relax(x, y, x + 1, y + 1, kDiagonal);
                relax(x, y, x, y + 1, kStraight);
                relax(x, y, x - 1, y + 1, kDiagonal);
                relax(x, y, x + 1, y, kStraight);
            }
            for (int x = 1; x < width; ++x) relax(x, y, x - 1, y, kStraight);
        }
    }
};

constexpr double kTypical = 0.9;
// Multiple of the median distance: pixels farther from all measurements lie in a hole, such as the
// sky between two towers.
constexpr std::uint32_t kHole = 4;
constexpr int kLargest_px = 1024;

constexpr double kJoined = 0.5;
constexpr double kLeastKnown = 0.001;  // fewer measurements show no surface

double share(long long part, long long whole) {
    return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0;
}

}  // namespace

std::vector<PlaneAt> measurements_of(const DisparityMap& map) {
    std::vector<PlaneAt> found;
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x)
            if (DisparityMap::known(map.at(x, y))) found.push_back({x, y, map.at(x, y)});
    return found;
}

NearestMeasurements find_nearest(const std::vector<PlaneAt>& measurements, int width, int height,
                                 const Image& left) {
    const std::size_t pixels = static_cast<std::size_t>(width) * height;
    NearestMeasurements nearest{width, height, std::vector<std::uint32_t>(pixels, kNoMeasurement),
                                std::vector<std::uint32_t>(pixels, kFar)};
    Sweep sweep{width, height, left, nearest};
    for (std::size_t i = 0; i < measurements.size(); ++i) {
        const std::size_t at = sweep.at(measurements[i].x, measurements[i].y);
        nearest.index[at] = static_cast<std::uint32_t>(i);
        nearest.distance[at] = 0;
    }
    for (int round = 0; round < (left.empty() ? 1 : 2); ++round) {
        sweep.downwards();
        sweep.upwards();
    }
    return nearest;
}

int typical_distance_px(const DisparityMap& map, const NearestMeasurements& nearest) {
    const int width = map.width, height = map.height;
    std::vector<int> first(width, height), last(width, -1);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            if (DisparityMap::known(map.at(x, y))) {
                first[x] = std::min(first[x], y);
                last[x] = y;
            }
    constexpr std::uint32_t kLargest = kLargest_px * kDistanceOne;
    std::vector<long long> histogram(kLargest + 1);
    long long total = 0;
    for (int y = 0; y < height; ++y) {
        const auto known = [&](int x) { return DisparityMap::known(map.at(x, y)); };
        int from = 0, to = width - 1;
        while (from <= to && !known(from)) ++from;
        while (to >= from && !known(to)) --to;
        for (int x = 0; x < width; ++x) {
            if ((y < first[x] || y > last[x]) && (x < from || x > to)) continue;
            const std::uint32_t distance = nearest.distance[static_cast<std::size_t>(y) * width + x];
            if (distance == 0) continue;
            ++histogram[std::min(distance, kLargest)];
            ++total;
        }
    }
    // Returns the distance that the share `part` of `count` pixels do not exceed, at most `end`.
    const auto percentile = [&](double part, std::uint32_t end, double count) {
        double below = 0;
        for (std::uint32_t d = 1; d < end; ++d)
            if ((below += static_cast<double>(histogram[d])) >= part * count) return d;
        return end;
    };
    if (total == 0) return 1;
    const std::uint32_t end =
        std::min(kHole * percentile(0.5, kLargest, static_cast<double>(total)), kLargest) + 1;
    const auto scattered = std::accumulate(histogram.begin(), histogram.begin() + end, 0LL);
    const std::uint32_t typical = percentile(kTypical, end, static_cast<double>(scattered));
    return static_cast<int>((typical + kDistanceOne / 2) / kDistanceOne);
}

std::vector<std::uint8_t> pixels_to_fill(const DisparityMap& map, const NearestMeasurements& nearest,
                                         int typical_px) {
    const int radius = 3 * typical_px + 4;
    std::vector<std::uint8_t> mask(map.values.size());
    for (std::size_t i = 0; i < mask.size(); ++i) mask[i] = DisparityMap::known(map.values[i]);
    take_largest(mask, map.width, map.height, radius);
    take_least(mask, map.width, map.height, radius);
    const std::uint32_t near = kDistanceOne * static_cast<std::uint32_t>(typical_px + 2);
    for (std::size_t i = 0; i < mask.size(); ++i) mask[i] |= nearest.distance[i] <= near;
    return mask;
}

bool Sparsity::is_sparse() const {
    return known_share >= kLeastKnown && std::min(joined_along_rows, joined_along_columns) < kJoined;
}

Sparsity measure_sparsity(const DisparityMap& map) {
    long long known = 0, with_right = 0, with_below = 0, right = 0, below = 0;
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            if (!DisparityMap::known(map.at(x, y))) continue;
            ++known;
            if (x + 1 < map.width) {
                ++with_right;
                right += DisparityMap::known(map.at(x + 1, y));
            }
            if (y + 1 < map.height) {
                ++with_below;
                below += DisparityMap::known(map.at(x, y + 1));
            }
        }
    return {share(known, static_cast<long long>(map.values.size())), share(right, with_right),
            share(below, with_below)};
}

}  // namespace hexrelief::stages
