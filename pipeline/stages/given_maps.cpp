#include "pipeline/stages/given_maps.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <vector>

namespace hexrelief::stages {
namespace {

constexpr float kAgree_px = 1;         // largest difference of disparities that are the same
constexpr float kGivenStep_px = 1.5F;  // range of 3x3 given disparities beside a discontinuity, maybe blurred
constexpr float kRefinedStep_px = 2;   // the same of refined ones
constexpr int kNear_px = 3;            // of a discontinuity
constexpr double kMisplaced = 0.04;    // of the pixels near refined discontinuities; see the header
constexpr int kParts = 16;             // of a px and of a level: the unit of costs
constexpr int kMostDifferent = 40;     // levels; beyond them the pixels are just different
constexpr int kClearlyMoreAlike = 3;   // levels

using Flags = std::vector<std::uint8_t>;

// What the right view says of a pixel's disparity.
enum class Verdict : std::uint8_t { agrees, hidden, contradicts };

// A pixel beside the match counts as well: matches lie between pixels, and at a silhouette the next one is
// another surface's.
Verdict verdict_on(float d, const DisparityMap& right, int x, int y) {
    const long column = std::lround(x - static_cast<double>(d));
    if (column < 0 || column >= right.width) return Verdict::hidden;
    float nearest = -kUnknownDisparity;
    for (long beside = std::max(0L, column - 1); beside <= std::min<long>(right.width - 1, column + 1);
         ++beside) {
        const float seen = right.at(static_cast<int>(beside), y);
        if (!DisparityMap::known(seen)) continue;
        if (std::abs(seen - d) <= kAgree_px) return Verdict::agrees;
        nearest = std::max(nearest, seen);
    }
    return DisparityMap::known(nearest) && nearest < d ? Verdict::contradicts : Verdict::hidden;
}

// Returns how much a pixel's colour differs from that of its match, in 1/16 of a level.
int difference(const StereoPair& pair, int x, int y, float d) {
    const Image &left = pair.left, &right = pair.right;
    const double match = std::clamp(static_cast<double>(x) - d, 0.0, right.width - 1.0);
    const int column = static_cast<int>(match), next = std::min(column + 1, right.width - 1);
    const int share = static_cast<int>(std::floor((match - column) * kParts + 0.5));
    const int channels = std::min(left.channels, right.channels);
    int sum = 0;
    for (int c = 0; c < channels; ++c)
        sum += std::abs(kParts * left.at(x, y)[c] -
                        ((kParts - share) * right.at(column, y)[c] + share * right.at(next, y)[c]));
    return std::min(sum / channels, kParts * kMostDifferent);
}

std::vector<int> differences(const StereoPair& pair, const DisparityMap& map) {
    std::vector<int> all;
    all.reserve(map.values.size());
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            const float d = map.at(x, y);
            all.push_back(DisparityMap::known(d) ? difference(pair, x, y, d) : kParts * kMostDifferent);
        }
    return all;
}

// Returns the sum over 3x3 values, and of how many there are in the picture.
std::pair<int, int> sum_around(const std::vector<int>& values, int width, int height, int x, int y) {
    int sum = 0, count = 0;
    for (int v = std::max(0, y - 1); v <= std::min(height - 1, y + 1); ++v)
        for (int u = std::max(0, x - 1); u <= std::min(width - 1, x + 1); ++u, ++count)
            sum += values[static_cast<std::size_t>(v) * width + u];
    return {sum, count};
}

// Returns 1 for each pixel within kNear_px, along x and y, of 3x3 pixels whose disparities differ so much.
Flags near_steps(const DisparityMap& map, float step_px) {
    Flags near(map.values.size(), 0);
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            float least = kUnknownDisparity, largest = -kUnknownDisparity;
            for (int v = std::max(0, y - 1); v <= std::min(map.height - 1, y + 1); ++v)
                for (int u = std::max(0, x - 1); u <= std::min(map.width - 1, x + 1); ++u)
                    if (const float d = map.at(u, v); DisparityMap::known(d))
                        least = std::min(least, d), largest = std::max(largest, d);
            if (!(largest - least >= step_px)) continue;
            for (int v = std::max(0, y - kNear_px); v <= std::min(map.height - 1, y + kNear_px); ++v) {
                const std::size_t row = static_cast<std::size_t>(v) * map.width;
                std::fill(near.begin() + static_cast<std::ptrdiff_t>(row + std::max(0, x - kNear_px)),
                          near.begin() +
                              static_cast<std::ptrdiff_t>(row + std::min(map.width - 1, x + kNear_px) + 1),
                          std::uint8_t{1});
            }
        }
    return near;
}

}  // namespace

DisparityMap keep_given(const StereoPair& pair, const ViewMaps& given, DisparityMap refined, float least_px) {
    const int width = refined.width, height = refined.height;
    const std::vector<int> as_given = differences(pair, given.left), as_refined = differences(pair, refined);
    const Flags beside = near_steps(refined, kRefinedStep_px);
    Flags is_refined_alike(refined.values.size(), 0);
    std::size_t all = 0, misplaced = 0;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const std::size_t i = static_cast<std::size_t>(y) * width + x;
            const float own = given.left.values[i], other = refined.values[i];
            all += beside[i];
            if (!DisparityMap::known(own) || !DisparityMap::known(other) ||
                std::abs(own - other) <= kAgree_px || x < own || x < other)
                continue;
            const auto [own_sum, count] = sum_around(as_given, width, height, x, y);
            const int other_sum = sum_around(as_refined, width, height, x, y).first;
            is_refined_alike[i] = other_sum + count * kParts * kClearlyMoreAlike < own_sum;
            misplaced += is_refined_alike[i] && beside[i];
        }
    const bool are_misplaced = static_cast<double>(misplaced) > kMisplaced * static_cast<double>(all);
    const Flags near =
        are_misplaced ? near_steps(given.left, kGivenStep_px) : Flags(refined.values.size(), 0);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const std::size_t i = static_cast<std::size_t>(y) * width + x;
            const float own = given.left.values[i];
            if (!DisparityMap::known(own) || near[i]) continue;
            const Verdict verdict = verdict_on(own, given.right, x, y);
            if (verdict == Verdict::contradicts && (are_misplaced || is_refined_alike[i])) continue;
            refined.values[i] = std::max(own, least_px);
            refined.origins[i] = verdict == Verdict::agrees ? PixelOrigin::matched : PixelOrigin::filled;
        }
    return refined;
}

}  // namespace hexrelief::stages
