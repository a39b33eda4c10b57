#include "mesher/pixel_surfaces.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace hexrelief {
namespace {

// Of a lattice cell: up to where regions are specks.
constexpr double kHoleShare = 1;          // where nothing is known: it may as well be the surface around it
constexpr double kBackgroundShare = 0.3;  // background in a hole
constexpr double kSpeckShare = 0.05;
constexpr int kLeastSpeck_px = 5;

// The step that the map's disparities are rounded to: the least difference of horizontal neighbours.
float quantum_px(const PixelSurfaces& s) {
    constexpr float kLeast_px = 1.0f / 64;  // finer steps do not matter
    float quantum = 1;
    for (int y = 0; y < s.height; ++y) {
        const float* row = &s.disparity[static_cast<std::size_t>(y) * s.width];
        for (int x = 0; x + 1 < s.width; ++x) {
            if (!(row[x] > 0) || !(row[x + 1] > 0)) continue;
            const float difference = std::fabs(row[x] - row[x + 1]);
            if (difference > kLeast_px && difference < quantum) quantum = difference;
        }
    }
    return quantum;
}

// Whether a jump lies between d and its neighbour at `next`. Of a step that is spread over several pixels,
// only the steepest part is one, the first of equal ones. before, after: whether there are pixels at -next
// and 2 * next.
bool is_jump_at(const float* d, std::ptrdiff_t next, bool before, bool after, float least) {
    if (!step::is_jump(d[0], d[next], least)) return false;
    const float step = d[next] - d[0];
    if (!(d[0] > 0) || !(d[next] > 0)) return true;
    const auto stronger = [&](float other, bool or_equal) {
        if ((other > 0) != (step > 0)) return false;
        return or_equal ? std::fabs(other) >= std::fabs(step) : std::fabs(other) > std::fabs(step);
    };
    if (before && d[-next] > 0 && stronger(d[0] - d[-next], true)) return false;
    return !(after && d[2 * next] > 0 && stronger(d[2 * next] - d[next], false));
}

void find_jumps(PixelSurfaces& s, bool bridge) {
    const float least = bridge ? std::numeric_limits<float>::infinity() : s.jump_px;
    for (int y = 0; y < s.height; ++y)
        for (int x = 0; x < s.width; ++x) {
            const std::size_t i = static_cast<std::size_t>(y) * s.width + x;
            std::uint8_t flags = s.flags[i] & step::kTrusted;
            const float* d = &s.disparity[i];
            if (x + 1 < s.width && is_jump_at(d, 1, x > 0, x + 2 < s.width, least)) flags |= step::kJumpRight;
            if (y + 1 < s.height && is_jump_at(d, s.width, y > 0, y + 2 < s.height, least))
                flags |= step::kJumpDown;
            s.flags[i] = flags;
        }
}

std::uint32_t root(std::vector<std::uint32_t>& parents, std::uint32_t i) {
    while (parents[i] != i) i = parents[i] = parents[parents[i]];
    return i;
}

void join(std::vector<std::uint32_t>& parents, std::uint32_t a, std::uint32_t b) {
    a = root(parents, a);
    b = root(parents, b);
    parents[std::max(a, b)] = std::min(a, b);
}

// Which pixels lie in a region between jumps that is a speck, by
// is_speck(first pixel, pixels, background pixels).
template <typename IsSpeck>
std::vector<std::uint8_t> find_specks(const PixelSurfaces& s, const DisparityMap& map,
                                      const IsSpeck& is_speck) {
    const std::size_t count = s.disparity.size();
    const std::uint32_t width = static_cast<std::uint32_t>(s.width);
    std::vector<std::uint32_t> parents(count);
    std::iota(parents.begin(), parents.end(), std::uint32_t{0});
    for (std::uint32_t i = 0; i < count; ++i) {
        if ((i + 1) % width != 0 && !(s.flags[i] & step::kJumpRight)) join(parents, i, i + 1);
        if (i + width < count && !(s.flags[i] & step::kJumpDown)) join(parents, i, i + width);
    }
    std::vector<int> areas(count, 0), backgrounds(count, 0);
    for (std::uint32_t i = 0; i < count; ++i) {
        const std::uint32_t at = parents[i] = root(parents, i);
        ++areas[at];
        backgrounds[at] += !(s.disparity[i] > 0) && DisparityMap::known(map.values[i]) && map.values[i] > 0;
    }
    std::vector<std::uint8_t> speck(count, 0);
    for (std::uint32_t i = 0; i < count; ++i) {
        const std::uint32_t at = parents[i];
        speck[i] = is_speck(at, areas[at], backgrounds[at]);
    }
    return speck;
}

// Takes kTrusted from specks and hands them their neighbours' disparity.
void absorb(PixelSurfaces& s, std::vector<std::uint8_t> speck) {
    const std::size_t count = s.disparity.size();
    const std::uint32_t width = static_cast<std::uint32_t>(s.width);
    std::vector<std::uint32_t> waiting, next;
    for (std::uint32_t i = 0; i < count; ++i) {
        if (!speck[i]) continue;
        s.flags[i] &= static_cast<std::uint8_t>(~step::kTrusted);
        waiting.push_back(i);
    }
    // From the rim inwards, a ring a round, each pixel from its first settled neighbour: the right answer for
    // the few pixels that these are.
    while (!waiting.empty()) {
        std::vector<std::pair<std::uint32_t, float>> settled;
        next.clear();
        for (const std::uint32_t i : waiting) {
            float from = -1;
            if (i % width != 0 && !speck[i - 1]) from = std::max(from, s.disparity[i - 1]);
            if ((i + 1) % width != 0 && !speck[i + 1]) from = std::max(from, s.disparity[i + 1]);
            if (i >= width && !speck[i - width]) from = std::max(from, s.disparity[i - width]);
            if (i + width < count && !speck[i + width]) from = std::max(from, s.disparity[i + width]);
            if (from < 0)
                next.push_back(i);
            else
                settled.emplace_back(i, from);
        }
        if (settled.empty()) break;  // the whole map is specks
        for (const auto& [i, from] : settled) {
            s.disparity[i] = from;
            speck[i] = 0;
        }
        waiting.swap(next);
    }
}

// Sum over the channels, grey counted three times.
int color_step(const Image& image, int x, int y, int u, int v) {
    const std::uint8_t *a = image.at(x, y), *b = image.at(u, v);
    if (image.channels < 3) return 3 * std::abs(int(a[0]) - int(b[0]));
    return std::abs(int(a[0]) - int(b[0])) + std::abs(int(a[1]) - int(b[1])) +
           std::abs(int(a[2]) - int(b[2]));
}

void find_shifts(PixelSurfaces& s, const Image& color, float most_px) {
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
    for (int y = 0; y < s.height; ++y)
        for (int x = 0; x < s.width; ++x) {
            const std::size_t i = static_cast<std::size_t>(y) * s.width + x;
            if (s.flags[i] & step::kJumpRight) s.shifts[2 * i] = find(x, y, 0);
            if (s.flags[i] & step::kJumpDown) s.shifts[2 * i + 1] = find(x, y, 1);
        }
}

void sum_tiles(PixelSurfaces& s) {
    constexpr int kTile = PixelSurfaces::kTile_px;
    const int columns = (s.width + kTile - 1) / kTile + 1, rows = (s.height + kTile - 1) / kTile + 1;
    s.tile_columns = columns;
    s.tile_sums.assign(static_cast<std::size_t>(columns) * rows, 0);
    for (int y = 0; y < s.height; ++y)
        for (int x = 0; x < s.width; ++x)
            if (s.flags[static_cast<std::size_t>(y) * s.width + x] & (step::kJumpRight | step::kJumpDown))
                ++s.tile_sums[static_cast<std::size_t>(y / kTile + 1) * columns + x / kTile + 1];
    for (int r = 1; r < rows; ++r)
        for (int c = 1; c < columns; ++c) {
            std::uint32_t* at = &s.tile_sums[static_cast<std::size_t>(r) * columns + c];
            *at += *(at - 1) + *(at - columns) - *(at - columns - 1);
        }
}

}  // namespace

bool PixelSurfaces::may_cross(const Vec2f& a, const Vec2f& b) const {
    const auto tile = [](float v, int size) {
        return std::clamp(static_cast<int>(v), 0, size - 1) / kTile_px;
    };
    const std::size_t c0 = tile(std::min(a.x, b.x) - 1, width), c1 = tile(std::max(a.x, b.x), width) + 1;
    const std::size_t r0 = tile(std::min(a.y, b.y) - 1, height), r1 = tile(std::max(a.y, b.y), height) + 1;
    const std::size_t n = static_cast<std::size_t>(tile_columns);
    return tile_sums[r1 * n + c1] + tile_sums[r0 * n + c0] != tile_sums[r0 * n + c1] + tile_sums[r1 * n + c0];
}

PixelSurfaces find_surfaces(const DisparityMap& map, float background_px, const Image* color, double cell_px,
                            const SheetConfig& config) {
    PixelSurfaces s{map.width, map.height, 0, map.values, {}, {}, 0, {}};
    s.flags.assign(map.values.size(), 0);
    for (std::size_t i = 0; i < s.disparity.size(); ++i) {
        float& d = s.disparity[i];
        if (!DisparityMap::known(d) || !(d > 0) || d < background_px) d = 0;
        s.flags[i] = step::kTrusted;
    }
    s.jump_px = config.max_disparity_jump_px > 0 ? static_cast<float>(config.max_disparity_jump_px)
                                                 : 1 + 0.5f * quantum_px(s);
    const bool bridge = config.discontinuities == Discontinuities::bridge;
    find_jumps(s, bridge);
    // Holes first: surfaces that they have torn to specks hang together again.
    absorb(s, find_specks(s, map, [&](std::uint32_t first, int area, int background) {
               return !(s.disparity[first] > 0) && area < kHoleShare * cell_px &&
                      background < kBackgroundShare * cell_px;
           }));
    find_jumps(s, bridge);
    const int least_px = std::max(kLeastSpeck_px, static_cast<int>(kSpeckShare * cell_px));
    absorb(s, find_specks(s, map, [&](std::uint32_t, int area, int) { return area < least_px; }));
    find_jumps(s, bridge);
    sum_tiles(s);
    if (color && config.color_shift_px > 0) find_shifts(s, *color, static_cast<float>(config.color_shift_px));
    return s;
}

}  // namespace hexrelief
