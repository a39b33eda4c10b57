#include "mesher/pixel_surfaces.h"

#include <algorithm>
#include <limits>

#include "mesher/specks.h"

namespace hexrelief {
namespace {

// Runs body(first, last) on shares of the rows.
template <typename Body>
void each_rows(const PixelSurfaces& s, Team& team, const Body& body) {
    team.for_ranges(static_cast<std::size_t>(s.height), [&](std::size_t first, std::size_t last) {
        body(static_cast<int>(first), static_cast<int>(last));
    });
}

float quantum_px(const PixelSurfaces& s, Team& team) {
    std::vector<float> quanta(team.size(), 1.0f);
    team.run([&](int thread) {
        float quantum = 1;
        const int end = static_cast<int>(team.share(s.height, thread + 1));
        for (int y = static_cast<int>(team.share(s.height, thread)); y < end; ++y) {
            const float* row = &s.disparity[static_cast<std::size_t>(y) * s.width];
            for (int x = 0; x + 1 < s.width; ++x) {
                const float difference = step::distance(row[x], row[x + 1]);
                if (difference < quantum && step::shows_quantum(row[x], row[x + 1])) quantum = difference;
            }
        }
        quanta[thread] = quantum;
    });
    return *std::min_element(quanta.begin(), quanta.end());
}

// Steps between the pixels d and their neighbours on the right and below, into flags.
#if defined(__x86_64__)
__attribute__((target_clones("avx512f", "avx2", "default")))
#endif
void find_steps(const float* d, const float* below, int count, float least, std::uint8_t* flags) {
#pragma GCC ivdep
    for (int x = 0; x < count; ++x)
        flags[x] = static_cast<std::uint8_t>((flags[x] & step::kTrusted) |
                                             step::steps_at(d[x], d[x + 1], below[x], least));
}

void find_jumps_in_row(PixelSurfaces& s, int y, float least) {
    const int width = s.width;
    const float* d = &s.disparity[static_cast<std::size_t>(y) * width];
    const float* below = y + 1 < s.height ? d + width : d;
    std::uint8_t* flags = &s.flags[static_cast<std::size_t>(y) * width];
    find_steps(d, below, width - 1, least, flags);
    const float last[2] = {d[width - 1], d[width - 1]};  // nothing on its right
    find_steps(last, below + width - 1, 1, least, flags + width - 1);
    for (int x = 0; x < width; ++x)
        for (int down = 0; down < 2; ++down) {
            const std::uint8_t jump = down ? step::kJumpDown : step::kJumpRight;
            if ((flags[x] & jump) && !step::is_jump_of_step(d + x, {x, y, down}, width, s.height, least))
                flags[x] &= static_cast<std::uint8_t>(~jump);
        }
}

void find_jumps(PixelSurfaces& s, bool bridge, Team& team) {
    const float least = bridge ? std::numeric_limits<float>::infinity() : s.jump_px;
    each_rows(s, team, [&](int first, int last) {
        for (int y = first; y < last; ++y) find_jumps_in_row(s, y, least);
    });
}

void find_shifts(PixelSurfaces& s, const Image& color, float most_px, Team& team) {
    s.shifts.assign(2 * s.disparity.size(), 0);
    const auto find = [&](int x, int y, int down) {
        return step::shift_at(color.pixels.data(), color.channels, {x, y, down}, s.width, s.height, most_px);
    };
    each_rows(s, team, [&](int first, int last) {
        for (int y = first; y < last; ++y)
            for (int x = 0; x < s.width; ++x) {
                const std::size_t i = static_cast<std::size_t>(y) * s.width + x;
                if (s.flags[i] & step::kJumpRight) s.shifts[2 * i] = find(x, y, 0);
                if (s.flags[i] & step::kJumpDown) s.shifts[2 * i + 1] = find(x, y, 1);
            }
    });
}

void sum_tiles(PixelSurfaces& s, Team& team) {
    constexpr int kTile = step::kTile_px;
    const int columns = step::tile_sum_count(s.width), rows = step::tile_sum_count(s.height);
    s.tile_columns = columns;
    s.tile_sums.assign(static_cast<std::size_t>(columns) * rows, 0);
    team.for_ranges(static_cast<std::size_t>(rows - 1), [&](std::size_t first, std::size_t last) {
        for (std::size_t r = first; r < last; ++r) {
            std::uint32_t* sums = &s.tile_sums[(r + 1) * columns + 1];
            const int end = std::min(s.height, static_cast<int>(r + 1) * kTile);
            for (int y = static_cast<int>(r) * kTile; y < end; ++y) {
                const std::uint8_t* flags = &s.flags[static_cast<std::size_t>(y) * s.width];
                for (int x = 0; x < s.width; ++x)
                    sums[x / kTile] += (flags[x] & (step::kJumpRight | step::kJumpDown)) != 0;
            }
        }
    });
    for (int r = 1; r < rows; ++r)
        for (int c = 1; c < columns; ++c) {
            std::uint32_t* at = &s.tile_sums[static_cast<std::size_t>(r) * columns + c];
            *at += *(at - 1) + *(at - columns) - *(at - columns - 1);
        }
}

}  // namespace

PixelSurfaces find_surfaces(const DisparityMap& map, float background_px, const Image* color, double cell_px,
                            const SheetConfig& config, Team& team) {
    PixelSurfaces s{map.width, map.height, 0, map.values, {}, {}, 0, {}};
    s.flags.assign(map.values.size(), step::kTrusted);
    team.for_ranges(s.disparity.size(), [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i)
            s.disparity[i] = step::foreground(s.disparity[i], background_px);
    });
    s.jump_px = config.max_disparity_jump_px > 0 ? static_cast<float>(config.max_disparity_jump_px)
                                                 : step::jump_of_quantum(quantum_px(s, team));
    const bool bridge = config.discontinuities == Discontinuities::bridge;
    absorb_holes(s, map, cell_px, team);  // first: surfaces that they have torn to specks hang together again
    find_jumps(s, bridge, team);
    if (!absorb_specks(s, step::least_region_px(cell_px), team).empty()) find_jumps(s, bridge, team);
    sum_tiles(s, team);
    if (color && config.color_shift_px > 0)
        find_shifts(s, *color, static_cast<float>(config.color_shift_px), team);
    return s;
}

}  // namespace hexrelief
