#include "mesher/pixel_surfaces.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hexrelief {
namespace {

// Of a lattice cell: up to where regions are specks.
constexpr double kHoleShare = 1;          // where nothing is known: it may as well be the surface around it
constexpr double kBackgroundShare = 0.3;  // background in a hole
constexpr double kSpeckShare = 0.05;
constexpr int kLeastSpeck_px = 5;

// Higher steps next to a still higher one are two rims that meet, not one that is spread over two pixels:
// closed, the triangles there would join the lowest surface with the highest.
constexpr float kMostSpread_px = 5;

// The lesser of the mean slopes over so many rows above and below a step excuses steps of so many times it:
// the slopes of maps in whole pixels are uneven.
constexpr int kSlopeReach_px = 6;
constexpr float kSlopeShare = 2;

// Runs body(first, last) on shares of the rows.
template <typename Body>
void each_rows(const PixelSurfaces& s, Team& team, const Body& body) {
    team.for_ranges(static_cast<std::size_t>(s.height), [&](std::size_t first, std::size_t last) {
        body(static_cast<int>(first), static_cast<int>(last));
    });
}

// The step that the map's disparities are rounded to: the least difference of horizontal neighbours.
float quantum_px(const PixelSurfaces& s, Team& team) {
    constexpr float kLeast_px = 1.0f / 64;  // finer steps do not matter
    std::vector<float> quanta(team.size(), 1.0f);
    team.run([&](int thread) {
        float quantum = 1;
        const int end = static_cast<int>(team.share(s.height, thread + 1));
        for (int y = static_cast<int>(team.share(s.height, thread)); y < end; ++y) {
            const float* row = &s.disparity[static_cast<std::size_t>(y) * s.width];
            for (int x = 0; x + 1 < s.width; ++x) {
                const float difference = std::fabs(row[x] - row[x + 1]);
                if (difference > kLeast_px && difference < quantum && row[x] > 0 && row[x + 1] > 0)
                    quantum = difference;
            }
        }
        quanta[thread] = quantum;
    });
    return *std::min_element(quanta.begin(), quanta.end());
}

// Of a step that is spread over several pixels, only the steepest part is a jump, the first of equal ones,
// and whatever is too high for that. before, after: whether there are pixels at -next and 2 * next.
bool is_steepest(const float* d, std::ptrdiff_t next, bool before, bool after) {
    const float step = d[next] - d[0];
    if (!(d[0] > 0) || !(d[next] > 0) || std::fabs(step) > kMostSpread_px) return true;
    const auto stronger = [&](float other, bool or_equal) {
        if ((other > 0) != (step > 0)) return false;
        return or_equal ? std::fabs(other) >= std::fabs(step) : std::fabs(other) > std::fabs(step);
    };
    if (before && d[-next] > 0 && stronger(d[0] - d[-next], true)) return false;
    return !(after && d[2 * next] > 0 && stronger(d[2 * next] - d[next], false));
}

// Whether a step down a column is part of a slope, such as a floor's seen at a grazing angle: both cameras
// see that at any slope. above, below: how many rows there are over and under the step's two.
bool is_slope(const float* d, std::ptrdiff_t next, int above, int below, float least) {
    const std::ptrdiff_t up = std::min(above, kSlopeReach_px), down = std::min(below, kSlopeReach_px);
    if (up == 0 || down == 0) return false;
    const float first = d[-up * next], upper = d[0], lower = d[next], last = d[(1 + down) * next];
    if (!(first > 0) || !(upper > 0) || !(lower > 0) || !(last > 0)) return false;
    const float sign = lower > upper ? 1.0f : -1.0f;
    const float slope = std::min(sign * (upper - first) / static_cast<float>(up),
                                 sign * (last - lower) / static_cast<float>(down));
    return sign * (lower - upper) - kSlopeShare * std::max(0.0f, slope) <= least;
}

// Steps between the pixels d and their neighbours on the right and below, into flags.
#if defined(__x86_64__)
__attribute__((target_clones("avx512f", "avx2", "default")))
#endif
void find_steps(const float* d, const float* below, int count, float least, std::uint8_t* flags) {
#pragma GCC ivdep
    for (int x = 0; x < count; ++x)
        flags[x] = static_cast<std::uint8_t>((flags[x] & step::kTrusted) |
                                             (step::is_jump(d[x], d[x + 1], least) ? step::kJumpRight : 0) |
                                             (step::is_jump(d[x], below[x], least) ? step::kJumpDown : 0));
}

void find_jumps_in_row(PixelSurfaces& s, int y, float least) {
    const int width = s.width;
    const float* d = &s.disparity[static_cast<std::size_t>(y) * width];
    const float* below = y + 1 < s.height ? d + width : d;
    std::uint8_t* flags = &s.flags[static_cast<std::size_t>(y) * width];
    find_steps(d, below, width - 1, least, flags);
    const float last[2] = {d[width - 1], d[width - 1]};  // nothing on its right
    find_steps(last, below + width - 1, 1, least, flags + width - 1);
    for (int x = 0; x < width; ++x) {
        if (!(flags[x] & (step::kJumpRight | step::kJumpDown))) continue;
        if ((flags[x] & step::kJumpRight) && !is_steepest(d + x, 1, x > 0, x + 2 < width))
            flags[x] &= static_cast<std::uint8_t>(~step::kJumpRight);
        if ((flags[x] & step::kJumpDown) && (!is_steepest(d + x, width, y > 0, y + 2 < s.height) ||
                                             is_slope(d + x, width, y, s.height - 2 - y, least)))
            flags[x] &= static_cast<std::uint8_t>(~step::kJumpDown);
    }
}

void find_jumps(PixelSurfaces& s, bool bridge, Team& team) {
    const float least = bridge ? std::numeric_limits<float>::infinity() : s.jump_px;
    each_rows(s, team, [&](int first, int last) {
        for (int y = first; y < last; ++y) find_jumps_in_row(s, y, least);
    });
}

// Pixels of a row between two jumps, and the run that stands for its region: an earlier one, or itself.
struct Run {
    std::uint32_t first, end;  // in the map
    std::uint32_t parent;
};

std::uint32_t root(std::vector<Run>& runs, std::uint32_t i) {
    while (runs[i].parent != i) i = runs[i].parent = runs[runs[i].parent].parent;
    return i;
}

// All runs, joined to regions.
std::vector<Run> find_runs(const PixelSurfaces& s) {
    const std::uint32_t width = static_cast<std::uint32_t>(s.width), count = width * s.height;
    std::vector<Run> runs;
    std::size_t above = 0;  // the first run of the row before that may touch the present one
    for (std::uint32_t row = 0; row < count; row += width) {
        for (std::uint32_t first = row, i = row; i < row + width; ++i) {
            if (i + 1 < row + width && !(s.flags[i] & step::kJumpRight)) continue;
            const std::uint32_t own = static_cast<std::uint32_t>(runs.size()), end = i + 1;
            runs.push_back({first, end, own});
            for (; row > 0 && runs[above].first + width < end; ++above) {
                const std::uint32_t from = std::max(first, runs[above].first + width),
                                    to = std::min(end, runs[above].end + width);
                const bool open = std::any_of(&s.flags[from - width], &s.flags[to - width],
                                              [](std::uint8_t f) { return !(f & step::kJumpDown); });
                if (open) {
                    const std::uint32_t a = root(runs, static_cast<std::uint32_t>(above)),
                                        b = root(runs, own);
                    runs[std::max(a, b)].parent = std::min(a, b);
                }
                if (runs[above].end + width > end) break;  // it reaches below the next run as well
            }
            first = end;
        }
    }
    return runs;
}

constexpr std::uint8_t kUnsettled = 128;  // a flag while specks are absorbed

// Takes kTrusted from specks, regions that is_speck(whether it is foreground, pixels, background pixels)
// tells, and hands them their neighbours' disparity. Returns whether there are any.
template <typename IsSpeck>
bool absorb_specks(PixelSurfaces& s, const DisparityMap& map, const IsSpeck& is_speck) {
    struct Region {
        int area = 0, background = 0;
    };
    const std::uint32_t width = static_cast<std::uint32_t>(s.width),
                        count = static_cast<std::uint32_t>(s.disparity.size());
    std::vector<Run> runs = find_runs(s);
    std::vector<Region> regions(runs.size());
    for (Run& run : runs) {
        run.parent = runs[run.parent].parent;  // its root: parents come first
        Region& region = regions[run.parent];
        region.area += static_cast<int>(run.end - run.first);
        if (s.disparity[run.first] > 0) continue;
        for (std::uint32_t i = run.first; i < run.end; ++i)
            region.background += DisparityMap::known(map.values[i]) && map.values[i] > 0;
    }
    std::vector<std::uint32_t> waiting, next;
    for (const Run& run : runs) {
        const Region& region = regions[run.parent];
        if (!is_speck(s.disparity[run.first] > 0, region.area, region.background)) continue;
        for (std::uint32_t i = run.first; i < run.end; ++i) {
            s.flags[i] = kUnsettled;
            waiting.push_back(i);
        }
    }
    const bool any = !waiting.empty();
    // From the rim inwards, a ring a round, each pixel from its nearest settled neighbour: the right answer
    // for the few pixels that these are.
    while (!waiting.empty()) {
        std::vector<std::pair<std::uint32_t, float>> settled;
        next.clear();
        for (const std::uint32_t i : waiting) {
            float from = -1;
            const auto look_at = [&](std::uint32_t j) {
                if (!(s.flags[j] & kUnsettled)) from = std::max(from, s.disparity[j]);
            };
            if (i % width != 0) look_at(i - 1);
            if ((i + 1) % width != 0) look_at(i + 1);
            if (i >= width) look_at(i - width);
            if (i + width < count) look_at(i + width);
            if (from < 0)
                next.push_back(i);
            else
                settled.emplace_back(i, from);
        }
        if (settled.empty()) break;  // the whole map is specks
        for (const auto& [i, from] : settled) {
            s.disparity[i] = from;
            s.flags[i] = 0;
        }
        waiting.swap(next);
    }
    return any;
}

// Sum over the channels, grey counted three times.
int color_step(const Image& image, int x, int y, int u, int v) {
    const std::uint8_t *a = image.at(x, y), *b = image.at(u, v);
    if (image.channels < 3) return 3 * std::abs(int(a[0]) - int(b[0]));
    return std::abs(int(a[0]) - int(b[0])) + std::abs(int(a[1]) - int(b[1])) +
           std::abs(int(a[2]) - int(b[2]));
}

void find_shifts(PixelSurfaces& s, const Image& color, float most_px, Team& team) {
    s.shifts.assign(2 * s.disparity.size(), 0);
    const auto find = [&](int x, int y, int down) {
        int steps[5];
        for (int k = 0; k < 5; ++k) {
            const int at = k - 2, u = down ? x : x + at, v = down ? y + at : y;
            const int p = down ? x : u + 1, q = down ? v + 1 : y;
            const bool inside = u >= 0 && v >= 0 && p < s.width && q < s.height;
            steps[k] = inside ? color_step(color, u, v, p, q) : 0;
        }
        return static_cast<std::int8_t>(128 * step::edge_offset(steps, most_px));
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
        for (std::size_t i = first; i < last; ++i) {
            float& d = s.disparity[i];
            if (!DisparityMap::known(d) || !(d > 0) || d < background_px) d = 0;
        }
    });
    s.jump_px = config.max_disparity_jump_px > 0 ? static_cast<float>(config.max_disparity_jump_px)
                                                 : 1 + 0.5f * quantum_px(s, team);
    const bool bridge = config.discontinuities == Discontinuities::bridge;
    find_jumps(s, bridge, team);
    // Holes first: surfaces that they have torn to specks hang together again.
    const auto is_small_hole = [&](bool foreground, int area, int background) {
        return !foreground && area < kHoleShare * cell_px && background < kBackgroundShare * cell_px;
    };
    if (absorb_specks(s, map, is_small_hole)) find_jumps(s, bridge, team);
    const int least_px = std::max(kLeastSpeck_px, static_cast<int>(kSpeckShare * cell_px));
    if (absorb_specks(s, map, [&](bool, int area, int) { return area < least_px; }))
        find_jumps(s, bridge, team);
    sum_tiles(s, team);
    if (color && config.color_shift_px > 0)
        find_shifts(s, *color, static_cast<float>(config.color_shift_px), team);
    return s;
}

}  // namespace hexrelief
