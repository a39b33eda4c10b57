#include "pipeline/stages/densify/planes.h"

#include <algorithm>
#include <cmath>

namespace hexrelief::stages {
namespace {

constexpr int kReach = 3, kMostOffsets = (2 * kReach + 1) * (2 * kReach + 1);
constexpr float kSteepest = 2;     // px of disparity per px
constexpr float kReach_px = 1.5f;  // measurements farther off a plane belong to another surface
// Cost of a plane that fits; largest ratio to a flat plane's cost for a plane that replaces it.
constexpr float kGood = 0.05f, kBetter = 0.45f;
constexpr int kTried = 6;  // measurements whose pairs give planes to try
// Regularisation towards a plane that faces the camera: decides if all measurements lie on one line.
constexpr float kRidge = 0.01f;

struct Slopes {
    float x = 0, y = 0;
};

// A measurement relative to the one whose plane is sought.
struct Offset {
    float x, y, d, weight;

    float off(Slopes s) const { return d - s.x * x - s.y * y; }
};

struct Neighbours {
    Offset offsets[kMostOffsets];
    int count = 0;
    float weight = 0;

    // Returns the plane's cost, as a share of the cost if all neighbours were on other surfaces.
    float cost(Slopes s) const {
        float sum = 0;
        for (int i = 0; i < count; ++i) {
            const float off = offsets[i].off(s) / kReach_px;
            sum += offsets[i].weight * std::min(off * off, 1.0f);
        }
        return weight > 0 ? sum / weight : 0;
    }
    // Returns the least squares plane of the neighbours that lie within twice the reach of the given plane.
    Slopes fitted(Slopes s) const {
        float xx = 0, xy = 0, yy = 0, xd = 0, yd = 0, sum = 0;
        for (int i = 0; i < count; ++i) {
            const Offset& o = offsets[i];
            const float t = o.off(s) / (2 * kReach_px);
            if (!(t * t < 1)) continue;
            const float w = o.weight * (1 - t * t);
            xx += w * o.x * o.x;
            xy += w * o.x * o.y;
            yy += w * o.y * o.y;
            xd += w * o.x * o.d;
            yd += w * o.y * o.d;
            sum += w;
        }
        xx += kRidge * sum;
        yy += kRidge * sum;
        const float determinant = xx * yy - xy * xy;
        if (!(determinant > 0)) return s;
        return {std::clamp((xd * yy - yd * xy) / determinant, -kSteepest, kSteepest),
                std::clamp((yd * xx - xd * xy) / determinant, -kSteepest, kSteepest)};
    }
    // Returns the best of the planes through the measurement and two neighbours, if it is much better than a
    // flat plane; else the flat plane.
    Slopes best_pair(float least_determinant) const {
        Slopes best;
        float least = kBetter * cost(best);
        const int step = std::max(1, count / kTried);
        for (int i = 0; i < count; i += step)
            for (int k = i + step; k < count; k += step) {
                const Offset &a = offsets[i], &b = offsets[k];
                const float determinant = a.x * b.y - a.y * b.x;
                if (std::abs(determinant) < least_determinant) continue;
                const Slopes s{(a.d * b.y - b.d * a.y) / determinant, (b.d * a.x - a.d * b.x) / determinant};
                if (std::abs(s.x) > kSteepest || std::abs(s.y) > kSteepest) continue;
                const float c = cost(s);
                if (c < least) {
                    least = c;
                    best = s;
                }
            }
        return best;
    }
};

Neighbours neighbours_of(std::uint32_t own, const std::vector<PlaneAt>& planes,
                         const NearestMeasurements& nearest, int stride_px) {
    Neighbours found;
    const PlaneAt& at = planes[own];
    std::uint32_t last = own;
    for (int j = -kReach; j <= kReach; ++j)
        for (int i = -kReach; i <= kReach; ++i) {
            const std::uint32_t k = nearest.of(at.x + i * stride_px, at.y + j * stride_px);
            if (k == kNoMeasurement || k == own || k == last) continue;
            last = k;
            const float weight = 1 / static_cast<float>(1 + i * i + j * j);
            found.offsets[found.count++] = {static_cast<float>(planes[k].x - at.x),
                                            static_cast<float>(planes[k].y - at.y), planes[k].d - at.d,
                                            weight};
            found.weight += weight;
        }
    return found;
}

Slopes slopes_of(const Neighbours& neighbours, int stride_px) {
    Slopes s = neighbours.fitted(neighbours.fitted({}));
    if (neighbours.cost(s) <= kGood) return s;
    s = neighbours.best_pair(static_cast<float>(stride_px));
    return neighbours.fitted(neighbours.fitted(s));
}

}  // namespace

void fit_planes(std::vector<PlaneAt>& planes, const NearestMeasurements& nearest, int stride_px,
                ThreadPool& pool) {
    // Only positions and disparities are read and only slopes are written, so the order of
    // measurements does not matter.
    pool.parallel_for_chunks(planes.size(), [&](std::size_t first, std::size_t end) {
        for (std::size_t m = first; m < end; ++m) {
            const Slopes s = slopes_of(
                neighbours_of(static_cast<std::uint32_t>(m), planes, nearest, stride_px), stride_px);
            planes[m].slope_x = s.x;
            planes[m].slope_y = s.y;
        }
    });
}

}  // namespace hexrelief::stages
