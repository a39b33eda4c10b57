#include "pipeline/stages/dequantize/relax.h"

#include <algorithm>
#include <utility>

#include "pipeline/base/simd.h"

namespace hexrelief::stages {
namespace {

// The curvatures of the bending lie between 0 and 64. These steps are the fastest of their number for those
// from 64 / 16 on; longer waves are left to the coarser levels. Two rounds of four steps are better than one
// of eight, whose first steps are so long that the bounds cut off most of their gain.
constexpr int kRounds = 2, kSteps = 4;
constexpr float kLargestCurvature = 64, kLeastCurvature = 64.f / (kSteps * kSteps);
// Threads take longer to start and to meet than one takes for a level of fewer pixels.
constexpr std::size_t kFewPixels = 16384;
// cos((2 k + 1) pi / 8)
constexpr float kChebyshev[kSteps] = {0.92387953f, 0.38268343f, -0.38268343f, -0.92387953f};

// The second differences of one row, with a border of one pixel.
struct Bends {
    explicit Bends(int width) : xx(static_cast<std::size_t>(width) + 2), yy(xx), xy(xx) {}
    std::vector<float> xx, yy, xy;

    void clear() {
        for (auto* row : {&xx, &yy, &xy}) std::fill(row->begin(), row->end(), 0.f);
    }
};

HEXRELIEF_VECTORS void second_differences(const float* own, int stride, const std::uint8_t* flags, int width,
                                          float* __restrict xx, float* __restrict yy, float* __restrict xy) {
    const float *above = own - stride, *below = own + stride;
    for (int x = 0; x < width; ++x) {
        const float along_x = own[x - 1] - 2 * own[x] + own[x + 1];
        const float along_y = above[x] - 2 * own[x] + below[x];
        const float twist = (own[x] - own[x + 1]) - (below[x] - below[x + 1]);
        xx[x] = flags[x] & kBendsX ? along_x : 0.f;
        yy[x] = flags[x] & kBendsY ? along_y : 0.f;
        xy[x] = flags[x] & kTwists ? twist : 0.f;
    }
}

// Pointers to the rows' first pixels. In the row above only yy and xy are read, in the row below only yy.
struct BendRows {
    const float *xx, *yy, *xy, *yy_above, *xy_above, *yy_below;
};

struct Step {
    float length, pull, half_px;
};

HEXRELIEF_VECTORS void descend(const BendRows& bends, const float* smooth, const float* given, Step step,
                               int width, float* __restrict out) {
    const float *xx = bends.xx, *yy = bends.yy, *xy = bends.xy;
    const float *yy_above = bends.yy_above, *xy_above = bends.xy_above, *yy_below = bends.yy_below;
    for (int x = 0; x < width; ++x) {
        const float bend_x = xx[x - 1] - 2 * xx[x] + xx[x + 1];
        const float bend_y = yy_above[x] - 2 * yy[x] + yy_below[x];
        const float twist = (xy[x] - xy[x - 1]) - (xy_above[x] - xy_above[x - 1]);
        const float slope = bend_x + bend_y + 2 * twist + step.pull * (smooth[x] - given[x]);
        const float moved = smooth[x] - step.length * slope;
        const float least = given[x] - step.half_px, most = given[x] + step.half_px;
        const float raised = moved < least ? least : moved;
        out[x] = raised > most ? most : raised;
    }
}

// Descends by a length that falls with each pixel's own pull.
HEXRELIEF_VECTORS void descend(const BendRows& bends, const float* smooth, const float* given,
                               const float* pull, float length, int width, float* __restrict out) {
    const float *xx = bends.xx, *yy = bends.yy, *xy = bends.xy;
    const float *yy_above = bends.yy_above, *xy_above = bends.xy_above, *yy_below = bends.yy_below;
    for (int x = 0; x < width; ++x) {
        const float bend_x = xx[x - 1] - 2 * xx[x] + xx[x + 1];
        const float bend_y = yy_above[x] - 2 * yy[x] + yy_below[x];
        const float twist = (xy[x] - xy[x - 1]) - (xy_above[x] - xy_above[x - 1]);
        const float slope = bend_x + bend_y + 2 * twist + pull[x] * (smooth[x] - given[x]);
        out[x] = smooth[x] - length * slope / (kLargestCurvature + pull[x]);
    }
}

// Does one step on the rows first .. end - 1. step: descends a row.
template <typename Descend>
void relax_rows(const PyramidLevel& level, const Descend& step, int first, int end, float* out) {
    Bends above(level.width), own(level.width), below(level.width);
    const auto find = [&](int y, Bends& bends) {
        if (y < 0 || y >= level.height) return bends.clear();
        const std::size_t row = level.at(0, y);
        second_differences(&level.smooth[row], level.stride, &level.flags[row], level.width, &bends.xx[1],
                           &bends.yy[1], &bends.xy[1]);
    };
    find(first - 1, above);
    find(first, own);
    for (int y = first; y < end; ++y) {
        find(y + 1, below);
        const std::size_t row = level.at(0, y);
        step({&own.xx[1], &own.yy[1], &own.xy[1], &above.yy[1], &above.xy[1], &below.yy[1]}, row, out + row);
        std::swap(above, own);
        std::swap(own, below);
    }
}

template <typename Descend>
void relax_level(PyramidLevel& level, std::vector<float>& next, ThreadPool& pool, const Descend& step) {
    const auto relax_share = [&](std::size_t first, std::size_t end) {
        relax_rows(level, step, static_cast<int>(first), static_cast<int>(end), next.data());
    };
    const auto rows = static_cast<std::size_t>(level.height);
    if (level.smooth.size() < kFewPixels)
        relax_share(0, rows);
    else
        pool.parallel_for(rows, relax_share);
    level.smooth.swap(next);
}

}  // namespace

void relax(PyramidLevel& level, float pull, float half_px, ThreadPool& pool) {
    const float least = kLeastCurvature + pull, most = kLargestCurvature + pull;
    std::vector<float> next = level.smooth;
    for (int k = 0; k < kRounds * kSteps; ++k) {
        const float cosine = kChebyshev[k % kSteps];
        const Step step{1 / (0.5f * (most + least) - 0.5f * (most - least) * cosine), pull, half_px};
        relax_level(level, next, pool, [&](const BendRows& bends, std::size_t row, float* out) {
            descend(bends, &level.smooth[row], &level.given[row], step, level.width, out);
        });
    }
}

void relax_weighted(PyramidLevel& level, int rounds, ThreadPool& pool) {
    // Divided by the largest curvature and the pull, curvatures lie below 1.
    constexpr float kLeast = kLeastCurvature / kLargestCurvature;
    std::vector<float> next = level.smooth;
    for (int k = 0; k < rounds * kSteps; ++k) {
        const float length = 1 / (0.5f * (1 + kLeast) - 0.5f * (1 - kLeast) * kChebyshev[k % kSteps]);
        relax_level(level, next, pool, [&](const BendRows& bends, std::size_t row, float* out) {
            descend(bends, &level.smooth[row], &level.given[row], &level.pull[row], length, level.width, out);
        });
    }
}

}  // namespace hexrelief::stages
