#include "pipeline/stages/dequantize/pyramid.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mesher/common/column_slope_step.h"
#include "pipeline/base/simd.h"

namespace hexrelief::stages {
namespace {

constexpr int kLeastSide_px = 4;  // least side of a level that is halved

bool has(std::uint8_t flags, std::uint8_t asked) {
    return (flags & asked) == asked;
}

void find_joins(PyramidLevel& level, float join_px, ThreadPool& pool) {
    pool.parallel_for_each(level.height, [&](int y) {
        const std::size_t row = level.at(0, y);
        const float *own = &level.given[row], *below = own + level.stride;
        std::uint8_t* flags = &level.flags[row];
        const int beneath = level.height - 2 - y;
        // Whether a pixel takes part is read off its given value, which is 0 if it does not; its flag
        // may be being written by another thread.
        for (int x = 0; x < level.width; ++x) {
            const bool right = own[x] != 0 && own[x + 1] != 0 && std::abs(own[x] - own[x + 1]) <= join_px;
            const bool down = own[x] != 0 && below[x] != 0 && std::abs(own[x] - below[x]) <= join_px;
            flags[x] = static_cast<std::uint8_t>((own[x] != 0 ? kIsSmoothed : 0) | (right ? kJoinsRight : 0) |
                                                 (down ? kJoinsBelow : 0));
        }
        for (int x = 0; x < level.width; ++x)
            if (!has(flags[x], kJoinsBelow) && own[x] != 0 && below[x] != 0 &&
                step::is_slope(own + x, level.stride, y, beneath, join_px))
                flags[x] |= kJoinsBelow;
    });
}

// Sets kBendsX, kBendsY and kTwists. The joins of all pixels must be known.
void find_bends(PyramidLevel& level, ThreadPool& pool) {
    const auto joins = level.flags;
    pool.parallel_for_each(level.height, [&](int y) {
        const std::size_t row = level.at(0, y);
        const std::uint8_t *own = &joins[row], *above = own - level.stride, *below = own + level.stride;
        std::uint8_t* flags = &level.flags[row];
        for (int x = 0; x < level.width; ++x) {
            const bool bends_x = own[x] & own[x - 1] & kJoinsRight;
            const bool bends_y = own[x] & above[x] & kJoinsBelow;
            const bool twists = (own[x] & below[x] & kJoinsRight) && (own[x] & own[x + 1] & kJoinsBelow);
            flags[x] = static_cast<std::uint8_t>(own[x] | (bends_x ? kBendsX : 0) | (bends_y ? kBendsY : 0) |
                                                 (twists ? kTwists : 0));
        }
    });
}

PyramidLevel finest_level(const DisparityMap& map, float half_quantum_px, float join_px, ThreadPool& pool) {
    PyramidLevel level(map.width, map.height);
    pool.parallel_for_each(map.height, [&](int y) {
        const float* row = &map.values[y * static_cast<std::size_t>(map.width)];
        float* given = &level.given[level.at(0, y)];
        for (int x = 0; x < map.width; ++x)
            given[x] = DisparityMap::known(row[x]) && row[x] > half_quantum_px ? row[x] : 0;
    });
    find_joins(level, join_px, pool);
    find_bends(level, pool);
    return level;
}

// Builds the next coarser level. A square of four joined pixels has kTwists at its first pixel.
PyramidLevel half_size(const PyramidLevel& fine, ThreadPool& pool) {
    PyramidLevel level(fine.width / 2, fine.height / 2);
    if (!fine.pull.empty()) level.pull.resize(level.given.size());
    const auto is_square = [&](int x, int y) {
        return x < level.width && y < level.height && has(fine.flags[fine.at(2 * x, 2 * y)], kTwists);
    };
    pool.parallel_for_each(level.height, [&](int y) {
        for (int x = 0; x < level.width; ++x) {
            if (!is_square(x, y)) continue;
            const std::size_t i = level.at(x, y), from = fine.at(2 * x, 2 * y), under = from + fine.stride;
            level.given[i] = 0.25f * ((fine.given[from] + fine.given[from + 1]) +
                                      (fine.given[under] + fine.given[under + 1]));
            if (!fine.pull.empty()) {
                float sum = 0, weighted = 0;
                for (const std::size_t k : {from, from + 1, under, under + 1}) {
                    sum += fine.pull[k];
                    weighted += fine.pull[k] * fine.given[k];
                }
                if (sum > 0) level.given[i] = weighted / sum;
                level.pull[i] = 4 * sum;  // a wave of twice the length bends 16 times less
            }
            // Two adjacent squares are joined if the square between them is: then both pairs of pixels
            // across their common side are joined.
            const bool right = is_square(x + 1, y) && has(fine.flags[from + 1], kTwists);
            const bool down = is_square(x, y + 1) && has(fine.flags[under], kTwists);
            level.flags[i] =
                static_cast<std::uint8_t>(kIsSmoothed | (right ? kJoinsRight : 0) | (down ? kJoinsBelow : 0));
        }
    });
    find_bends(level, pool);
    return level;
}

void add_levels(std::vector<PyramidLevel>& pyramid, int levels, ThreadPool& pool) {
    while (static_cast<int>(pyramid.size()) < levels &&
           std::min(pyramid.back().width, pyramid.back().height) >= kLeastSide_px)
        pyramid.push_back(half_size(pyramid.back(), pool));
    for (PyramidLevel& level : pyramid) level.smooth = level.given;
}

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

// Returns the slope of the energy in a pixel's value, which `pull` draws to the given one.
HEXRELIEF_INLINED float slope_at(BendRows bends, const float* smooth, const float* given, float pull, int x) {
    const float *xx = bends.xx, *yy = bends.yy, *xy = bends.xy, *xy_above = bends.xy_above;
    const float bend_x = xx[x - 1] - 2 * xx[x] + xx[x + 1];
    const float bend_y = bends.yy_above[x] - 2 * yy[x] + bends.yy_below[x];
    const float twist = (xy[x] - xy[x - 1]) - (xy_above[x] - xy_above[x - 1]);
    return bend_x + bend_y + 2 * twist + pull * (smooth[x] - given[x]);
}

HEXRELIEF_VECTORS void descend(BendRows bends, const float* smooth, const float* given, Step step, int width,
                               float* __restrict out) {
    for (int x = 0; x < width; ++x) {
        const float moved = smooth[x] - step.length * slope_at(bends, smooth, given, step.pull, x);
        const float least = given[x] - step.half_px, most = given[x] + step.half_px;
        const float raised = moved < least ? least : moved;
        out[x] = raised > most ? most : raised;
    }
}

// Descends by a length that falls with each pixel's own pull.
HEXRELIEF_VECTORS void descend(BendRows bends, const float* smooth, const float* given, const float* pull,
                               float length, int width, float* __restrict out) {
    for (int x = 0; x < width; ++x)
        out[x] =
            smooth[x] - length * slope_at(bends, smooth, given, pull[x], x) / (kLargestCurvature + pull[x]);
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

PyramidLevel::PyramidLevel(int columns, int rows)
    : width(columns),
      height(rows),
      stride(columns + 2),
      given(static_cast<std::size_t>(stride) * (rows + 2)),
      flags(given.size()) {}

std::vector<PyramidLevel> build_pyramid(const DisparityMap& map, float half_quantum_px, float join_px,
                                        int levels, ThreadPool& pool) {
    std::vector<PyramidLevel> pyramid;
    pyramid.push_back(finest_level(map, half_quantum_px, join_px, pool));
    add_levels(pyramid, levels, pool);
    return pyramid;
}

void complete_pyramid(std::vector<PyramidLevel>& pyramid, int levels, ThreadPool& pool) {
    find_bends(pyramid.front(), pool);
    add_levels(pyramid, levels, pool);
}

void prolong(const PyramidLevel& coarse, PyramidLevel& fine, float half_px, ThreadPool& pool) {
    const auto put = [&](std::size_t i, float value) {
        fine.smooth[i] = std::clamp(value, fine.given[i] - half_px, fine.given[i] + half_px);
    };
    pool.parallel_for_each(coarse.height, [&](int y) {
        for (int x = 0; x < coarse.width; ++x) {
            const std::size_t i = coarse.at(x, y), stride = static_cast<std::size_t>(coarse.stride);
            if (!has(coarse.flags[i], kIsSmoothed)) continue;
            const bool to_right = coarse.flags[i] & kJoinsRight, to_below = coarse.flags[i] & kJoinsBelow;
            const bool to_left = coarse.flags[i - 1] & kJoinsRight;
            const bool to_above = coarse.flags[i - stride] & kJoinsBelow;
            const float own = coarse.smooth[i];
            float right = to_right ? coarse.smooth[i + 1] - own : 0;
            float left = to_left ? coarse.smooth[i - 1] - own : 0;
            float below = to_below ? coarse.smooth[i + stride] - own : 0;
            float above = to_above ? coarse.smooth[i - stride] - own : 0;
            if (!to_right) right = -left;
            if (!to_left) left = -right;
            if (!to_below) below = -above;
            if (!to_above) above = -below;
            const std::size_t from = fine.at(2 * x, 2 * y), under = from + fine.stride;
            put(from, own + 0.25f * (left + above));
            put(from + 1, own + 0.25f * (right + above));
            put(under, own + 0.25f * (left + below));
            put(under + 1, own + 0.25f * (right + below));
        }
    });
}

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
