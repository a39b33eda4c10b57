#include "pipeline/stages/dequantize/evidence.h"

#include <algorithm>
#include <cmath>

namespace hexrelief::stages {
namespace {

constexpr int kMeanRadius_px = 7, kWindowRadius_px = 3;
constexpr float kMostMove_px = 1;  // the levels are linear no farther
constexpr float kLeastMiss = 1;    // levels; pictures are in whole ones
// A pixel whose levels differ by this many standard deviations has a quarter of its certainty.
constexpr float kDoubtful = 3;
constexpr float kDeviationOfMedian = 1.4826f;

Plane grey_of(const Image& image, ThreadPool& pool) {
    Plane grey(image.width, image.height);
    for_rows(pool, image.height, [&](int y) {
        for (int x = 0; x < image.width; ++x) {
            const std::uint8_t* const c = image.at(x, y);
            grey.row(y)[x] = image.channels < 3 ? c[0] : 0.25f * static_cast<float>(c[0] + 2 * c[1] + c[2]);
        }
    });
    return grey;
}

// Returns the sums over squares; beyond the border the nearest pixel counts.
Plane box_sums(const Plane& plane, int radius, ThreadPool& pool) {
    Plane across(plane.width, plane.height), sums(plane.width, plane.height);
    const int last = plane.width - 1;
    for_rows(pool, plane.height, [&](int y) {
        const float* const in = plane.row(y);
        float* const out = across.row(y);
        double sum = 0;
        for (int i = -radius; i <= radius; ++i) sum += in[std::clamp(i, 0, last)];
        for (int x = 0; x < plane.width; ++x) {
            out[x] = static_cast<float>(sum);
            sum += static_cast<double>(in[std::min(x + radius + 1, last)]) - in[std::max(x - radius, 0)];
        }
    });
    for_rows(pool, plane.height, [&](int y) {
        float* const out = sums.row(y);
        for (int j = -radius; j <= radius; ++j) {
            const float* const in = across.row(std::clamp(y + j, 0, plane.height - 1));
            for (int x = 0; x < plane.width; ++x) out[x] += in[x];
        }
    });
    return sums;
}

void subtract_means(Plane& plane, ThreadPool& pool) {
    constexpr float kShare = 1.f / ((2 * kMeanRadius_px + 1) * (2 * kMeanRadius_px + 1));
    const Plane sums = box_sums(plane, kMeanRadius_px, pool);
    for (std::size_t i = 0; i < plane.values.size(); ++i) plane.values[i] -= kShare * sums.values[i];
}

// Interpolates by the cubic of Catmull and Rom. width >= 4.
float level_at(const float* row, int width, float x) {
    const int at = std::clamp(static_cast<int>(std::floor(x)), 1, width - 3);
    const float t = x - static_cast<float>(at);
    const float p0 = row[at - 1], p1 = row[at], p2 = row[at + 1], p3 = row[at + 2];
    return p1 + 0.5f * t * (p2 - p0 + t * (2 * p0 - 5 * p1 + 4 * p2 - p3 + t * (3 * (p1 - p2) + p3 - p0)));
}

// Returns the slopes along x of both pictures' mean, by Sobel's operator.
Plane slopes_of(const Plane& left, const Plane& right, ThreadPool& pool) {
    Plane slopes(left.width, left.height);
    const int last_x = left.width - 1, last_y = left.height - 1;
    for_rows(pool, left.height, [&](int y) {
        for (int x = 0; x <= last_x; ++x) {
            const auto rise = [&](int v) {
                v = std::clamp(v, 0, last_y);
                const int before = std::max(x - 1, 0), behind = std::min(x + 1, last_x);
                return (left.row(v)[behind] - left.row(v)[before]) +
                       (right.row(v)[behind] - right.row(v)[before]);
            };
            slopes.row(y)[x] = 0.0625f * (rise(y - 1) + 2 * rise(y) + rise(y + 1));
        }
    });
    return slopes;
}

}  // namespace

PairLevels::PairLevels(const StereoPair& pair, ThreadPool& pool)
    : left_(grey_of(pair.left, pool)), right_(grey_of(pair.right, pool)), left_detail_(left_) {
    subtract_means(left_detail_, pool);
}

Evidence PairLevels::evidence_for(const DisparityMap& map, ThreadPool& pool) const {
    const int width = map.width, height = map.height;
    std::vector<std::uint8_t> is_seen(map.values.size());
    Plane seen = left_;  // what the right picture shows of each pixel
    for_rows(pool, height, [&](int y) {
        for (int x = 0; x < width; ++x) {
            const std::size_t i = static_cast<std::size_t>(y) * width + x;
            if (map.origins[i] != PixelOrigin::matched) continue;
            const float at = static_cast<float>(x) - map.values[i];
            if (!(at >= 1 && at <= static_cast<float>(width - 2))) continue;
            is_seen[i] = 1;
            seen.row(y)[x] = level_at(right_.row(y), width, at);
        }
    });
    subtract_means(seen, pool);
    const Plane slopes = slopes_of(left_detail_, seen, pool);

    const auto size_at = [&](std::size_t i) { return is_seen[i] ? std::abs(slopes.values[i]) : -1; };
    const float steep = median_of(is_seen.size(), pool, size_at);
    const auto miss_at = [&](std::size_t i) {
        return size_at(i) >= steep ? std::abs(seen.values[i] - left_detail_.values[i]) : -1;
    };
    const float miss = std::max(kLeastMiss, kDeviationOfMedian * median_of(is_seen.size(), pool, miss_at));

    Evidence evidence{Plane(width, height), Plane(width, height), Plane(0, 0), miss};
    for_rows(pool, height, [&](int y) {
        for (int x = 0; x < width; ++x) {
            const std::size_t i = static_cast<std::size_t>(y) * width + x;
            if (!is_seen[i]) continue;
            const float slope = slopes.values[i], off = seen.values[i] - left_detail_.values[i];
            const float doubt = 1 + off * off / (kDoubtful * kDoubtful * miss * miss);
            constexpr float kFlat = 1e-3f;  // keeps the quotient finite
            evidence.certainty.row(y)[x] = slope * slope / (miss * miss * doubt * doubt);
            evidence.target.row(y)[x] = map.values[i] + std::clamp(slope * off / (slope * slope + kFlat),
                                                                   -kMostMove_px, kMostMove_px);
        }
    });
    evidence.around = box_sums(evidence.certainty, kWindowRadius_px, pool);
    return evidence;
}

}  // namespace hexrelief::stages
