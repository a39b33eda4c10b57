#include "pipeline/stages/by_colour/robust_plane.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "pipeline/base/simd.h"

namespace hexrelief::stages {
namespace {

constexpr std::size_t kTriples = 200, kLevels = 24;
constexpr double kLargestXSlope = 0.3, kLargestYSlope = 0.6;  // px per px
constexpr double kLeastArea = 0.05;  // of the samples' bounding box: twice that of a triple's triangle
constexpr double kOffPlane_px = 1.5;
constexpr int kFitRounds = 5;
constexpr std::size_t kLanes = 16;

// The samples' numbers, padded to whole batches by samples without weight.
struct Columns {
    std::vector<float> x, y, disparity, weight;

    explicit Columns(const std::vector<PlaneSample>& samples) {
        const std::size_t padded = (samples.size() + kLanes - 1) / kLanes * kLanes;
        for (std::vector<float>* column : {&x, &y, &disparity, &weight}) column->assign(padded, 0);
        for (std::size_t i = 0; i < samples.size(); ++i) {
            x[i] = samples[i].x;
            y[i] = samples[i].y;
            disparity[i] = samples[i].disparity;
            weight[i] = samples[i].weight;
        }
    }
};

using Column = const float* __restrict;

// Returns the weight of the samples within kOnPlane_px. `soft`: each counts less the farther it is off.
template <bool soft>
HEXRELIEF_INLINED float share_of(Column x, Column y, Column disparity, Column weight, std::size_t count,
                                 float x_slope, float y_slope, float at_origin) {
    constexpr auto kLargest = static_cast<float>(kOnPlane_px * kOnPlane_px);
    float sums[kLanes] = {};
    for (std::size_t i = 0; i < count; i += kLanes)
        for (std::size_t k = 0; k < kLanes; ++k) {
            const float off = x_slope * x[i + k] + y_slope * y[i + k] + at_origin - disparity[i + k];
            const float rest = kLargest - off * off, own = weight[i + k];
            sums[k] += soft ? (rest > 0 ? rest : 0.0f) * own : rest > 0 ? own : 0.0f;
        }
    float sum = 0;
    for (const float lane : sums) sum += lane;
    return sum;
}
HEXRELIEF_VECTORS float soft_share(Column x, Column y, Column disparity, Column weight, std::size_t count,
                                   float x_slope, float y_slope, float at_origin) {
    return share_of<true>(x, y, disparity, weight, count, x_slope, y_slope, at_origin);
}
HEXRELIEF_VECTORS float hard_share(Column x, Column y, Column disparity, Column weight, std::size_t count,
                                   float x_slope, float y_slope, float at_origin) {
    return share_of<false>(x, y, disparity, weight, count, x_slope, y_slope, at_origin);
}

template <class Share>
float share_of(const Columns& c, const DisparityPlane& plane, const Share& share) {
    return share(c.x.data(), c.y.data(), c.disparity.data(), c.weight.data(), c.x.size(),
                 static_cast<float>(plane.x_slope), static_cast<float>(plane.y_slope),
                 static_cast<float>(plane.at_origin));
}

std::vector<DisparityPlane> candidates_of(const std::vector<PlaneSample>& samples) {
    const std::size_t count = samples.size();
    const auto by_x = [](const PlaneSample& a, const PlaneSample& b) { return a.x < b.x; };
    const auto by_y = [](const PlaneSample& a, const PlaneSample& b) { return a.y < b.y; };
    const auto [left, right] = std::minmax_element(samples.begin(), samples.end(), by_x);
    const auto [top, bottom] = std::minmax_element(samples.begin(), samples.end(), by_y);
    const double box = (right->x - left->x + 1.0) * (bottom->y - top->y + 1.0);
    std::vector<DisparityPlane> planes;
    for (std::uint64_t t = 0; t < kTriples; ++t) {  // large primes scatter the triples
        const PlaneSample& a = samples[t * 7919 % count];
        const PlaneSample& b = samples[(t * 104729 + count / 3) % count];
        const PlaneSample& c = samples[(t * 1299709 + 2 * count / 3) % count];
        const double bx = b.x - a.x, by = b.y - a.y, bd = b.disparity - a.disparity;
        const double cx = c.x - a.x, cy = c.y - a.y, cd = c.disparity - a.disparity;
        const double area = bx * cy - by * cx;
        if (std::abs(area) <= kLeastArea * box) continue;
        const double x_slope = (bd * cy - by * cd) / area, y_slope = (bx * cd - bd * cx) / area;
        if (std::abs(x_slope) >= kLargestXSlope || std::abs(y_slope) >= kLargestYSlope) continue;
        planes.push_back({x_slope, y_slope, a.disparity - x_slope * a.x - y_slope * a.y});
    }
    std::vector<float> levels;
    for (const PlaneSample& sample : samples) levels.push_back(sample.disparity);
    std::sort(levels.begin(), levels.end());
    for (std::size_t i = 0; i < kLevels; ++i)
        planes.push_back({0, 0, levels[(2 * i + 1) * count / (2 * kLevels)]});
    return planes;
}

// Least squares over the samples near the plane (Tukey's biweight), around their mean place.
DisparityPlane moved_to_samples(DisparityPlane plane, const std::vector<PlaneSample>& samples) {
    constexpr double kLeastVariance = 10;  // px^2: fewer or nearer samples say nothing about a slope
    double mean_x = 0, mean_y = 0;
    for (const PlaneSample& s : samples) {
        mean_x += s.x;
        mean_y += s.y;
    }
    mean_x /= static_cast<double>(samples.size());
    mean_y /= static_cast<double>(samples.size());
    for (int round = 0; round < kFitRounds; ++round) {
        double n = 0, x = 0, y = 0, d = 0, xx = kLeastVariance, xy = 0, yy = kLeastVariance, xd = 0, yd = 0;
        for (const PlaneSample& s : samples) {
            const double off = (plane.at(s.x, s.y) - s.disparity) / kOffPlane_px;
            if (std::abs(off) >= 1) continue;
            const double w = (1 - off * off) * (1 - off * off), u = s.x - mean_x, v = s.y - mean_y;
            n += w;
            x += w * u;
            y += w * v;
            d += w * s.disparity;
            xx += w * u * u;
            xy += w * u * v;
            yy += w * v * v;
            xd += w * u * s.disparity;
            yd += w * v * s.disparity;
        }
        if (n <= 0) return plane;
        const double a = xx - x * x / n, b = xy - x * y / n, c = yy - y * y / n;
        const double e = xd - x * d / n, f = yd - y * d / n, area = a * c - b * b;
        plane.x_slope = (e * c - b * f) / area;
        plane.y_slope = (a * f - b * e) / area;
        plane.at_origin =
            (d - plane.x_slope * x - plane.y_slope * y) / n - plane.x_slope * mean_x - plane.y_slope * mean_y;
    }
    return plane;
}

}  // namespace

std::optional<PlaneFit> fit_plane(const std::vector<PlaneSample>& samples, double least_share) {
    const std::vector<DisparityPlane> planes = candidates_of(samples);
    Columns columns(samples);
    float best = -1;
    PlaneFit fit;
    for (const DisparityPlane& plane : planes)
        if (const float soft = share_of(columns, plane, soft_share); soft > best) {
            best = soft;
            fit.plane = plane;
        }
    fit.plane = moved_to_samples(fit.plane, samples);
    fit.share = share_of(columns, fit.plane, hard_share);
    if (fit.share < least_share) return {};
    for (std::size_t i = 0; i < samples.size(); ++i)
        if (std::abs(fit.plane.at(samples[i].x, samples[i].y) - samples[i].disparity) <= kOffPlane_px)
            columns.weight[i] = 0;
    for (const DisparityPlane& plane : planes)
        fit.second_share = std::max<double>(fit.second_share, share_of(columns, plane, hard_share));
    return fit;
}

}  // namespace hexrelief::stages
