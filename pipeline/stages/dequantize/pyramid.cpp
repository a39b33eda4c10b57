#include "pipeline/stages/dequantize/pyramid.h"

#include <algorithm>
#include <cmath>

#include "mesher/common/column_slope_step.h"

namespace hexrelief::stages {
namespace {

constexpr int kLeastSide_px = 4;  // least side of a level that is halved

bool has(std::uint8_t flags, std::uint8_t asked) {
    return (flags & asked) == asked;
}

void find_joins(PyramidLevel& level, float join_px, ThreadPool& pool) {
    pool.parallel_for(static_cast<std::size_t>(level.height), [&](std::size_t first, std::size_t end) {
        for (std::size_t y = first; y < end; ++y) {
            const std::size_t row = level.at(0, static_cast<int>(y));
            const float *own = &level.given[row], *below = own + level.stride;
            std::uint8_t* flags = &level.flags[row];
            const int above = static_cast<int>(y), beneath = level.height - 2 - above;
            // Whether a pixel takes part is read off its given value, which is 0 if it does not; its flag may
            // be being written by another thread.
            for (int x = 0; x < level.width; ++x) {
                const bool right = own[x] != 0 && own[x + 1] != 0 && std::abs(own[x] - own[x + 1]) <= join_px;
                const bool down = own[x] != 0 && below[x] != 0 && std::abs(own[x] - below[x]) <= join_px;
                flags[x] = static_cast<std::uint8_t>((own[x] != 0 ? kIsSmoothed : 0) |
                                                     (right ? kJoinsRight : 0) | (down ? kJoinsBelow : 0));
            }
            for (int x = 0; x < level.width; ++x)
                if (!has(flags[x], kJoinsBelow) && own[x] != 0 && below[x] != 0 &&
                    step::is_slope(own + x, level.stride, above, beneath, join_px))
                    flags[x] |= kJoinsBelow;
        }
    });
}

// Sets kBendsX, kBendsY and kTwists. The joins of all pixels must be known.
void find_bends(PyramidLevel& level, ThreadPool& pool) {
    const auto joins = level.flags;
    pool.parallel_for(static_cast<std::size_t>(level.height), [&](std::size_t first, std::size_t end) {
        for (std::size_t y = first; y < end; ++y) {
            const std::size_t row = level.at(0, static_cast<int>(y));
            const std::uint8_t *own = &joins[row], *above = own - level.stride, *below = own + level.stride;
            std::uint8_t* flags = &level.flags[row];
            for (int x = 0; x < level.width; ++x) {
                const bool bends_x = own[x] & own[x - 1] & kJoinsRight;
                const bool bends_y = own[x] & above[x] & kJoinsBelow;
                const bool twists = (own[x] & below[x] & kJoinsRight) && (own[x] & own[x + 1] & kJoinsBelow);
                flags[x] = static_cast<std::uint8_t>(own[x] | (bends_x ? kBendsX : 0) |
                                                     (bends_y ? kBendsY : 0) | (twists ? kTwists : 0));
            }
        }
    });
}

PyramidLevel finest_level(const DisparityMap& map, float half_quantum_px, float join_px, ThreadPool& pool) {
    PyramidLevel level(map.width, map.height);
    pool.parallel_for(static_cast<std::size_t>(map.height), [&](std::size_t first, std::size_t end) {
        for (std::size_t y = first; y < end; ++y) {
            const float* row = &map.values[y * static_cast<std::size_t>(map.width)];
            float* given = &level.given[level.at(0, static_cast<int>(y))];
            for (int x = 0; x < map.width; ++x)
                given[x] = DisparityMap::known(row[x]) && row[x] > half_quantum_px ? row[x] : 0;
        }
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
    pool.parallel_for(static_cast<std::size_t>(level.height), [&](std::size_t first, std::size_t end) {
        for (int y = static_cast<int>(first); y < static_cast<int>(end); ++y)
            for (int x = 0; x < level.width; ++x) {
                if (!is_square(x, y)) continue;
                const std::size_t i = level.at(x, y), from = fine.at(2 * x, 2 * y),
                                  under = from + fine.stride;
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
                level.flags[i] = static_cast<std::uint8_t>(kIsSmoothed | (right ? kJoinsRight : 0) |
                                                           (down ? kJoinsBelow : 0));
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
    pool.parallel_for(static_cast<std::size_t>(coarse.height), [&](std::size_t first, std::size_t end) {
        for (int y = static_cast<int>(first); y < static_cast<int>(end); ++y)
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

}  // namespace hexrelief::stages
