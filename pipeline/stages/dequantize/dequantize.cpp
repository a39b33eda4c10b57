#include "pipeline/stages/dequantize/dequantize.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "pipeline/base/thread_pool.h"
#include "pipeline/data/four_neighbours.h"
#include "pipeline/stages/dequantize/noise.h"
#include "pipeline/stages/dequantize/pyramid.h"

namespace hexrelief::stages {
namespace {

// Largest difference of neighbours on one surface; the surface stage's own default.
constexpr float kJoined_px = 1.0001f;
// Share of half a quantum: whole pixels that are two apart must stay more than 1 px apart, a discontinuity.
constexpr double kFree = 0.97;
constexpr float kPullGrowth = 16;  // from one level to the next

constexpr int kLooks = 3;  // at the pictures
constexpr int kMostLevels = 9, kMostRounds = 64;
constexpr float kOneSurface_px = 1.0001f;  // neighbours on one surface; the surface stage's own default
// The standard deviation of the disparity of 7x7 pixels, px, from which on their levels tell none.
constexpr float kUnsure_px = 0.5f;
// That of a pixel's own disparity, px, if its levels tell none, and if it is filled.
constexpr float kUnsurePixel_px = 8, kFilledPixel_px = 2;
constexpr int kShortest = 80;  // discontinuities in the longer side; shorter ones are errors, or too small
// Those of blurred ones, which are what was matched steeply of an outline: they would hang as flakes.
constexpr int kShortestBlurred = 8;
// Those of soft ones, sharper and longer: they get skirts, as smooth bends would spread too far beside them.
constexpr int kShortestSoft = 4;
constexpr int kBlur_px = 3;  // beside a step, about the radius of the matcher's windows
// Of what rises within kBlur_px, less lies in a blurred or a soft discontinuity's steps.
constexpr float kBlurred = 0.8f, kSoft = 0.9f;
constexpr float kSkirtSlope = 1;  // px per pixel; the surface stage cuts what is steeper
// Surfaces may bend by so many powers of the misfit's growth more: 10 % make it twice as much.
constexpr int kDoublings = 3;

// Returns how much the map's surfaces bend: the standard deviation of second differences at neighbouring
// pixels if they are independent, by the median at a sixteenth of the longer side, where noise is small.
float bend_of(const DisparityMap& map, ThreadPool& pool) {
    constexpr int kDistances = 16;
    constexpr float kDeviationOfMedian = 1.4826f, kGrowth = 0.8165f;  // sqrt(2 / 3), times distance^1.5
    const int distance = std::max(map.width, map.height) / kDistances;
    // Along rows, then along columns.
    const auto size_at = [&](std::size_t i) {
        const bool is_row = i < map.values.size();
        const std::size_t first = is_row ? i : i - map.values.size(),
                          width = static_cast<std::size_t>(map.width);
        const std::size_t step = is_row ? distance : distance * width;
        if (is_row ? first % width + 2 * step >= width : first + 2 * step >= map.values.size()) return -1.f;
        for (int k = 0; k < 3; ++k)
            if (map.origins[first + k * step] != PixelOrigin::matched) return -1.f;
        const float* const d = &map.values[first];
        return std::abs(d[0] - 2 * d[step] + d[2 * step]);
    };
    const auto far = static_cast<float>(std::max(1, distance));
    return kDeviationOfMedian * median_of(2 * map.values.size(), pool, size_at) /
           (kGrowth * far * std::sqrt(far));
}

bool are_apart(const DisparityMap& map, std::size_t i, std::size_t other) {
    return DisparityMap::known(map.values[i]) && DisparityMap::known(map.values[other]) &&
           std::abs(map.values[i] - map.values[other]) > kOneSurface_px;
}

// Returns 1 for pixels beside a discontinuity.
std::vector<std::uint8_t> find_ends(const DisparityMap& map, ThreadPool& pool) {
    std::vector<std::uint8_t> is_end(map.values.size());
    pool.parallel_for_each(is_end.size(), [&](std::size_t i) {
        for_four_neighbours(i, map.width, map.height,
                            [&](std::size_t other) { is_end[i] |= are_apart(map, i, other); });
    });
    return is_end;
}

// The sizes of a discontinuity's steps between neighbours, and of what rises within kBlur_px on both sides.
struct Rise {
    float steps_px = 0, around_px = 0;

    bool is_below(float share) const { return steps_px < share * around_px; }
    // Adds the steps to a pixel's right and below it.
    void add(const DisparityMap& map, int x, int y) {
        for (const auto& [dx, dy] : {std::pair(1, 0), std::pair(0, 1)}) {
            const auto at = [&](int k) {
                return map.at(std::clamp(x + k * dx, 0, map.width - 1),
                              std::clamp(y + k * dy, 0, map.height - 1));
            };
            const float step = std::abs(at(1) - at(0)), around = std::abs(at(1 + kBlur_px) - at(-kBlur_px));
            if (!(step > kOneSurface_px) || !DisparityMap::known(step) || !DisparityMap::known(around))
                continue;
            steps_px += step;
            around_px += around;
        }
    }
};

// Returns 1 for the pixels along discontinuities that is_marked(length_px, rise) takes.
template <class IsMarked>
std::vector<std::uint8_t> find_steps(const DisparityMap& map, ThreadPool& pool, const IsMarked& is_marked) {
    const int width = map.width, height = map.height;
    std::vector<std::uint8_t> is_end = find_ends(map, pool), marked(is_end.size());
    std::vector<std::size_t> line;
    for (std::size_t start = 0; start < is_end.size(); ++start) {
        if (!is_end[start]) continue;
        is_end[start] = 0;
        line.assign(1, start);
        int left = width, right = 0, top = height, bottom = 0;
        Rise rise;
        for (std::size_t next = 0; next < line.size(); ++next) {
            const int x = static_cast<int>(line[next] % width), y = static_cast<int>(line[next] / width);
            left = std::min(left, x), right = std::max(right, x);
            top = std::min(top, y), bottom = std::max(bottom, y);
            rise.add(map, x, y);
            for (int v = std::max(0, y - 1); v <= std::min(height - 1, y + 1); ++v)
                for (int u = std::max(0, x - 1); u <= std::min(width - 1, x + 1); ++u) {
                    const std::size_t other = static_cast<std::size_t>(v) * width + u;
                    if (!is_end[other]) continue;
                    is_end[other] = 0;
                    line.push_back(other);
                }
        }
        if (is_marked(std::max(right - left, bottom - top), rise))
            for (const std::size_t i : line) marked[i] = 1;
    }
    return marked;
}

// Lets short soft discontinuities of the map as it was matched, where longer ones are not yet in pieces, fall
// from their nearer side on, as steeply as one surface may.
void add_skirts(DisparityMap& map, const DisparityMap& matched, ThreadPool& pool) {
    const int least = std::max(map.width, map.height) / kShortestSoft;
    const std::vector<std::uint8_t> falls = find_steps(matched, pool, [&](int length_px, const Rise& rise) {
        return length_px < least && rise.is_below(kSoft);
    });
    const std::size_t width = map.width, count = map.values.size();
    // The skirts of all nearer sides, by a distance transform: along rows and columns, there and back.
    std::vector<float> skirt(count, std::numeric_limits<float>::lowest());
    for (std::size_t i = 0; i < count; ++i)
        for_four_neighbours(i, map.width, map.height, [&](std::size_t other) {
            if (falls[i] && map.values[i] > map.values[other] && are_apart(map, i, other))
                skirt[i] = map.values[i];
        });
    const auto fall = [&](std::size_t from, std::size_t to) {
        skirt[to] = std::max(skirt[to], skirt[from] - kSkirtSlope);
    };
    for (std::size_t i = 0; i < count; ++i) {
        if (i % width > 0) fall(i - 1, i);
        if (i >= width) fall(i - width, i);
    }
    for (std::size_t i = count; i-- > 0;) {
        if ((i + 1) % width > 0) fall(i + 1, i);
        if (i + width < count) fall(i + width, i);
    }
    for (std::size_t i = 0; i < count; ++i)
        if (DisparityMap::known(map.values[i])) map.values[i] = std::max(map.values[i], skirt[i]);
}

// Returns the finest level: its values, `raise` above the map's, joins, and pulls, for bends of a variance.
PyramidLevel level_of(const DisparityMap& map, const Evidence& evidence, float variance, float raise,
                      ThreadPool& pool) {
    constexpr float kLeastAround = 1 / (kUnsure_px * kUnsure_px);
    constexpr float kOfUnsure = 1 / (kUnsurePixel_px * kUnsurePixel_px),
                    kOfFilled = 1 / (kFilledPixel_px * kFilledPixel_px);
    const auto width = static_cast<std::size_t>(map.width);
    const int longer = std::max(map.width, map.height);
    std::vector<std::uint8_t> is_unsure = find_steps(map, pool, [&](int length_px, const Rise& rise) {
        return length_px < longer / (rise.is_below(kBlurred) ? kShortestBlurred : kShortest);
    });
    PyramidLevel level(map.width, map.height);
    level.pull.resize(level.given.size());
    pool.parallel_for_each(map.height, [&](int y) {
        for (int x = 0; x < map.width; ++x) {
            const std::size_t i = y * width + x, at = level.at(x, y);
            if (!DisparityMap::known(map.values[i])) continue;
            const bool is_matched = map.origins[i] == PixelOrigin::matched;
            if (is_matched && evidence.around.values[i] < kLeastAround) is_unsure[i] = 1;
            const float certainty = is_unsure[i] ? 0 : is_matched ? evidence.certainty.values[i] : kOfFilled;
            level.given[at] = (is_matched && certainty > 0 ? evidence.target.values : map.values)[i] + raise;
            level.pull[at] = variance * std::max(certainty, kOfUnsure);
        }
    });
    pool.parallel_for_each(map.height, [&](int y) {
        for (int x = 0; x < map.width; ++x) {
            const std::size_t i = y * width + x;
            const auto joins = [&](std::size_t other) {
                return DisparityMap::known(map.values[other]) &&
                       ((is_unsure[i] && is_unsure[other]) || !are_apart(map, i, other));
            };
            if (!DisparityMap::known(map.values[i])) continue;
            level.flags[level.at(x, y)] = static_cast<std::uint8_t>(
                kIsSmoothed | (x + 1 < map.width && joins(i + 1) ? kJoinsRight : 0) |
                (y + 1 < map.height && joins(i + width) ? kJoinsBelow : 0));
        }
    });
    return level;
}

void smooth(std::vector<PyramidLevel>& pyramid, ThreadPool& pool) {
    constexpr float kNoBound = std::numeric_limits<float>::max();
    complete_pyramid(pyramid, kMostLevels, pool);
    for (std::size_t level = pyramid.size(); level-- > 0;) {
        if (level + 1 < pyramid.size()) prolong(pyramid[level + 1], pyramid[level], kNoBound, pool);
        relax_weighted(pyramid[level], std::min(kMostRounds, 2 << level), pool);
    }
}

}  // namespace

DisparityMap dequantize(const DisparityMap& map, double quantum_px, int threads,
                        const Smoothness& smoothness) {
    DisparityMap result = map;
    ThreadPool pool(threads);
    const auto half_px = static_cast<float>(0.5 * kFree * quantum_px);
    std::vector<PyramidLevel> pyramid = build_pyramid(map, half_px, kJoined_px, smoothness.levels, pool);
    std::vector<float> pulls = {smoothness.pull};
    while (pulls.size() < pyramid.size()) pulls.push_back(kPullGrowth * pulls.back());
    for (std::size_t level = pyramid.size(); level-- > 0;) {
        if (level + 1 < pyramid.size()) prolong(pyramid[level + 1], pyramid[level], half_px, pool);
        relax(pyramid[level], pulls[level], half_px, pool);
    }
    const PyramidLevel& fine = pyramid.front();
    pool.parallel_for_each(map.height, [&](int y) {
        for (int x = 0; x < map.width; ++x)
            if (fine.flags[fine.at(x, y)] & kIsSmoothed) result.at(x, y) = fine.smooth[fine.at(x, y)];
    });
    return result;
}

DisparityMap refine_by_pictures(const DisparityMap& map, const StereoPair& pair, int threads) {
    ThreadPool pool(threads);
    DisparityMap result = map;
    const float bend = bend_of(map, pool);
    float variance = bend * bend, first_miss = 0;
    if (!(variance > 0)) return result;
    const KnownRange range = known_range(map);
    const float raise = 1 - range.least;  // values of 0 would not take part
    const PairLevels levels(pair, pool);
    for (int look = 0; look < kLooks; ++look) {
        const Evidence evidence = levels.evidence_for(result, pool);
        if (look == 0) first_miss = evidence.miss;
        // Pictures that fit less well than at first tell that surfaces bend more.
        float growth = std::max(1.f, evidence.miss / first_miss);
        for (int k = 0; k < kDoublings; ++k) growth *= growth;
        variance *= growth * growth;
        std::vector<PyramidLevel> pyramid;
        pyramid.push_back(level_of(result, evidence, variance, raise, pool));
        smooth(pyramid, pool);
        const PyramidLevel& fine = pyramid.front();
        pool.parallel_for_each(map.height, [&](int y) {
            for (int x = 0; x < map.width; ++x)
                if (fine.flags[fine.at(x, y)] & kIsSmoothed)
                    result.at(x, y) =
                        std::clamp(fine.smooth[fine.at(x, y)] - raise, range.least, range.largest);
        });
    }
    add_skirts(result, map, pool);
    return result;
}

}  // namespace hexrelief::stages
