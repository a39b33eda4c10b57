#include "pipeline/job/matchers/given_maps.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <utility>
#include <vector>

#include "pipeline/base/opencv_squares.h"
#include "pipeline/matching/matcher.h"
#include "pipeline/stages/other_views/other_view.h"

namespace hexrelief::job {
namespace {

constexpr float kAgree_px = 1;         // largest difference of disparities that are the same
constexpr float kGivenStep_px = 1.5F;  // range of 3x3 given disparities beside a discontinuity, maybe blurred
constexpr float kRefinedStep_px = 2;   // the same of refined ones
constexpr int kNear_px = 3;            // of a discontinuity
constexpr double kMisplaced = 0.14;    // of the pixels near refined discontinuities; see the header
constexpr double kAtFault = 0.01;      // of all pixels; true maps have up to 0.0055
constexpr int kLevelParts = 16;        // of a px and of a level: the unit of costs
constexpr int kMostDifferent = 40;     // levels; beyond them the pixels are just different
constexpr int kUnlike = 8, kUnlikeTimes = 3;  // levels, and times the median: a pixel of another colour
constexpr int kSurelyUnlike = 20;     // levels, whatever the median is: the picture may be another scene's
constexpr int kClearlyMoreAlike = 3;  // levels

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
    const int share = static_cast<int>(std::floor((match - column) * kLevelParts + 0.5));
    const int channels = std::min(left.channels, right.channels);
    int sum = 0;
    for (int c = 0; c < channels; ++c)
        sum += std::abs(kLevelParts * left.at(x, y)[c] -
                        ((kLevelParts - share) * right.at(column, y)[c] + share * right.at(next, y)[c]));
    return std::min(sum / channels, kLevelParts * kMostDifferent);
}

std::vector<int> differences(const StereoPair& pair, const DisparityMap& map) {
    std::vector<int> all;
    all.reserve(map.values.size());
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            const float d = map.at(x, y);
            all.push_back(DisparityMap::known(d) ? difference(pair, x, y, d) : kLevelParts * kMostDifferent);
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

// Returns 1 for each pixel near 3x3 pixels whose disparities differ so much.
Flags near_steps(const DisparityMap& map, float step_px) {
    std::vector<float> least = map.values, largest = map.values;
    std::ranges::replace_if(least, std::not_fn(DisparityMap::known), kUnknownDisparity);
    std::ranges::replace_if(largest, std::not_fn(DisparityMap::known), -kUnknownDisparity);
    take_least(least, map.width, map.height, 1);
    take_largest(largest, map.width, map.height, 1);
    Flags steps(map.values.size());
    for (std::size_t i = 0; i < steps.size(); ++i) steps[i] = largest[i] - least[i] >= step_px;
    take_largest(steps, map.width, map.height, kNear_px);
    return steps;
}

// See refine_given(). Known disparities are at least `least_px`.
DisparityMap keep_given(const StereoPair& pair, const stages::ViewMaps& given, const Flags& unlike,
                        DisparityMap refined, float least_px) {
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
                std::abs(own - other) <= kRefinedStep_px || x < own || x < other)
                continue;
            const auto [own_sum, count] = sum_around(as_given, width, height, x, y);
            const int other_sum = sum_around(as_refined, width, height, x, y).first;
            is_refined_alike[i] = other_sum + count * kLevelParts * kClearlyMoreAlike < own_sum;
            misplaced += is_refined_alike[i] && beside[i];
        }
    std::vector<Verdict> verdicts;
    Flags at_fault = unlike;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const float own = given.left.at(x, y);
            verdicts.push_back(DisparityMap::known(own) ? verdict_on(own, given.right, x, y)
                                                        : Verdict::hidden);
            at_fault[verdicts.size() - 1] |= verdicts.back() == Verdict::contradicts;
        }
    Flags replaced(refined.values.size(), 0);
    const double share = static_cast<double>(misplaced) / std::max(1.0, static_cast<double>(all));
    if (share > kMisplaced) {
        const Flags near = near_steps(given.left, kGivenStep_px);
        Flags better = is_refined_alike;
        take_largest(better, width, height, kNear_px);
        for (std::size_t i = 0; i < replaced.size(); ++i) replaced[i] = near[i] || (at_fault[i] && better[i]);
    } else {
        for (std::size_t i = 0; i < replaced.size(); ++i) replaced[i] = at_fault[i] && is_refined_alike[i];
        if (static_cast<double>(std::ranges::count(replaced, std::uint8_t{1})) <=
            kAtFault * static_cast<double>(replaced.size()))
            replaced.assign(replaced.size(), 0);
    }
    for (std::size_t i = 0; i < replaced.size(); ++i) {
        const float own = given.left.values[i];
        if (!DisparityMap::known(own) || replaced[i]) continue;
        refined.values[i] = std::max(own, least_px);
        refined.origins[i] = verdicts[i] == Verdict::agrees ? PixelOrigin::matched : PixelOrigin::filled;
    }
    return refined;
}

// Returns the right view's map that the left view's implies: of the pixels that match there the nearest.
DisparityMap seen_from_right(const DisparityMap& left) {
    DisparityMap right{
        left.width, left.height, std::vector<float>(left.values.size(), kUnknownDisparity), {}};
    for (int y = 0; y < left.height; ++y)
        for (int x = 0; x < left.width; ++x) {
            const float d = left.at(x, y);
            if (!DisparityMap::known(d)) continue;
            const long column = std::lround(x - static_cast<double>(d));
            if (column < 0 || column >= left.width) continue;
            float& seen = right.at(static_cast<int>(column), y);
            seen = DisparityMap::known(seen) ? std::max(seen, d) : d;
        }
    return right;
}

// Returns the curves that bring the right picture to the left one's light, by what both maps agree on.
matching::LightCurves light_by(const StereoPair& pair, const DisparityMap& left, const DisparityMap& right) {
    matching::MatchedMap matches{left.width, left.height, {}, {}};
    for (int y = 0; y < left.height; ++y)
        for (int x = 0; x < left.width; ++x) {
            const float d = left.at(x, y);
            const bool is_sure = DisparityMap::known(d) && d >= 0 && d < stages::kLargestRange_px &&
                                 verdict_on(d, right, x, y) == Verdict::agrees;
            matches.disparities.push_back(is_sure ? static_cast<std::int16_t>(d * matching::kOnePixel)
                                                  : matching::kUnknown16);
            matches.is_matched.push_back(is_sure);
        }
    return matching::find_light(pair, matches, 0);
}

// Returns 1 for the pixels of the left view that the right camera sees by the maps, but in another colour,
// and their share of all that it sees.
std::pair<Flags, double> find_unlike(const StereoPair& pair, const DisparityMap& left,
                                     const DisparityMap& right) {
    const std::vector<int> all = differences(pair, left);
    Flags is_seen(left.values.size(), 0);
    for (int y = 0; y < left.height; ++y)
        for (int x = 0; x < left.width; ++x)
            is_seen[static_cast<std::size_t>(y) * left.width + x] =
                DisparityMap::known(left.at(x, y)) &&
                verdict_on(left.at(x, y), right, x, y) != Verdict::hidden;
    std::vector<std::pair<std::size_t, int>> seen;  // pixels, with the mean of those of their surface in 3x3
    for (int y = 0; y < left.height; ++y)
        for (int x = 0; x < left.width; ++x) {
            const std::size_t i = static_cast<std::size_t>(y) * left.width + x;
            if (!is_seen[i]) continue;
            int sum = 0, count = 0;
            for (int v = std::max(0, y - 1); v <= std::min(left.height - 1, y + 1); ++v)
                for (int u = std::max(0, x - 1); u <= std::min(left.width - 1, x + 1); ++u) {
                    const std::size_t k = static_cast<std::size_t>(v) * left.width + u;
                    if (is_seen[k] && std::abs(left.values[k] - left.values[i]) <= kAgree_px)
                        sum += all[k], ++count;
                }
            seen.emplace_back(i, sum / count);
        }
    Flags unlike(left.values.size(), 0);
    if (seen.empty()) return {unlike, 0};
    std::vector<int> sorted;
    for (const auto& [pixel, mean] : seen) sorted.push_back(mean);
    const int median = value_at_rank(sorted, sorted.size() / 2);
    const int most = std::min(kUnlikeTimes * median + kLevelParts * kUnlike, kLevelParts * kSurelyUnlike);
    std::size_t count = 0;
    for (const auto& [pixel, mean] : seen)
        if (mean > most) unlike[pixel] = 1, ++count;
    return {unlike, static_cast<double>(count) / static_cast<double>(seen.size())};
}

DisparityMap without(DisparityMap map, const Flags& hidden) {
    for (std::size_t i = 0; i < hidden.size(); ++i)
        if (hidden[i]) map.values[i] = kUnknownDisparity;
    return map;
}

// As check_by_picture(), for both views' maps.
PictureCheck refine_dense(StereoPair pair, const stages::ViewMaps& given,
                          const stages::DisparityConfig& config, int threads) {
    matching::relight(pair.right, light_by(pair, given.left, given.right), threads);
    const auto [unlike, share] = find_unlike(pair, given.left, given.right);
    const DisparityMap right_in_mirror = stages::mirrored(given.right);
    const Flags right_unlike =
        find_unlike(stages::mirrored(pair), right_in_mirror, stages::mirrored(given.left)).first;
    const stages::ViewMaps sure{without(given.left, unlike),
                                stages::mirrored(without(right_in_mirror, right_unlike)), true};
    DisparityMap refined = stages::refine_maps(pair, sure, config, threads);
    if (refined.origins.empty()) return {std::move(refined), share};
    const bool has_negative =
        std::ranges::any_of(given.left.values, [](float d) { return DisparityMap::known(d) && d < 0; });
    return {keep_given(pair, given, unlike, std::move(refined),
                       has_negative ? -kUnknownDisparity : 1.0F / matching::kOnePixel),
            share};
}

}  // namespace

DisparityMap refine_given(const StereoPair& pair, const stages::ViewMaps& given,
                          const stages::DisparityConfig& config, int threads) {
    if (!given.is_dense || config.fill == stages::DisparityFill::none)
        return stages::refine_maps(pair, given, config, threads);
    return refine_dense(pair, given, config, threads).map;
}

PictureCheck check_by_picture(StereoPair pair, const DisparityMap& left,
                              const stages::DisparityConfig& config, int threads) {
    PictureCheck check = refine_dense(std::move(pair), {left, seen_from_right(left), true}, config, threads);
    for (std::size_t i = 0; i < left.values.size(); ++i) {
        if (DisparityMap::known(left.values[i])) continue;
        check.map.values[i] = kUnknownDisparity;
        if (!check.map.origins.empty()) check.map.origins[i] = PixelOrigin::unknown;
    }
    return check;
}

}  // namespace hexrelief::job
