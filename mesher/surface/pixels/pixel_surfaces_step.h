// Finds which neighbouring pixels lie on one surface, by a team of threads (ThreadTeam, CooperativeGrid): one
// control flow for both backends. All functions are called by the whole team and end with a barrier.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "mesher/common/surface_config.h"
#include "mesher/surface/pixels/discontinuities_step.h"
#include "pipeline/base/shared_memory_step.h"

namespace hexrelief::step {

inline constexpr unsigned kHoleWord = 32;          // pixels of a row in which runs of holes are looked for
inline constexpr std::uint8_t kUnsettled = 128;    // flag of pixels that are being absorbed
inline constexpr std::size_t kMorePixelFlags = 7;  // beyond the map's, as pixels' flags are read in words

// The arrays of a map, of width * height entries if nothing else is said.
struct PixelArrays {
    int width, height;
    const float* map;          // px, +inf = unknown
    float* disparity;          // px, 0 = no foreground
    std::uint8_t* flags;       // see PixelView::flags; kMorePixelFlags more
    std::uint32_t* tile_sums;  // tile_sum_count() of the width times that of the height
    // Only for the search:
    unsigned *words,
        *numbers;  // hole_words(): those with pixels without foreground, and each one's place there
    unsigned *roots, *areas;  // of regions of such pixels: hole_words() * kHoleWord + 1 entries
    unsigned* pending;        // indices of pixels that are to be absorbed
    float* found;             // disparities that they take
    struct Counts {
        unsigned words, pending;
    } * counts;
    HEXRELIEF_HD std::size_t pixels() const { return static_cast<std::size_t>(width) * height; }
};

HEXRELIEF_HD unsigned hole_words_per_row(int width) {
    return (static_cast<unsigned>(width) + kHoleWord - 1) / kHoleWord;
}
HEXRELIEF_HD std::size_t hole_words(int width, int height) {
    return std::size_t{hole_words_per_row(width)} * static_cast<unsigned>(height);
}

// Calls visit(j) for the neighbours of pixel i.
template <typename Visit>
HEXRELIEF_TEAM void each_neighbour(const PixelArrays& p, unsigned i, const Visit& visit) {
    const unsigned width = static_cast<unsigned>(p.width), x = i % width;
    if (x != 0) visit(i - 1);
    if (x + 1 != width) visit(i + 1);
    if (i >= width) visit(i - width);
    if (i + width < p.pixels()) visit(i + width);
}

// Writes the disparities without background and half-occlusion steps, and trusts all pixels.
template <typename Team>
HEXRELIEF_TEAM void clean_pixels(const Team& team, const PixelArrays& p, float background_px, float least) {
    team.each_block(p.width, p.height, [&](int x0, int y) {
        constexpr int kBlock = Team::kBlock;
        const std::size_t first = static_cast<std::size_t>(y) * p.width + x0;
        float d[kBlock + 4];  // of the pixels from x0 - 2 on
        if (x0 >= 2 && x0 + kBlock + 2 <= p.width) {
            for (int k = 0; k < kBlock + 4; ++k) d[k] = foreground(p.map[first + k - 2], background_px);
        } else {
            for (int k = 0; k < kBlock + 4; ++k) {
                const int x = x0 + k - 2;
                d[k] = x >= 0 && x < p.width ? foreground(p.map[first + k - 2], background_px) : 0;
            }
        }
        const int count = min_of(kBlock, p.width - x0);
        for (int k = 0; k < count; ++k) {
            p.disparity[first + k] =
                between_half_occlusions(d[k], d[k + 1], d[k + 2], d[k + 3], d[k + 4], least);
            p.flags[first + k] = kTrusted;
        }
    });
}

// Successive pixels without foreground of a word: from its bit-th pixel on, which is pixel `first` of the
// map.
struct HoleRun {
    unsigned bit, first, count;
};

// Calls visit(run) for the runs of a word.
template <typename Visit>
HEXRELIEF_TEAM void each_hole_run(const PixelArrays& p, unsigned word, const Visit& visit) {
    const unsigned per_row = hole_words_per_row(p.width), x0 = word % per_row * kHoleWord,
                   width = static_cast<unsigned>(p.width), first = word / per_row * width + x0,
                   count = min_of(width - x0, kHoleWord);
    int any = 0;  // an integer, so that the loop vectorises
    for (unsigned k = 0; k < count; ++k) any |= !(p.disparity[first + k] > 0);
    for (unsigned end, k = 0; any != 0 && k < count; k = end) {
        for (end = k; end < count && !(p.disparity[first + end] > 0);) ++end;
        if (end > k) visit(HoleRun{k, first + k, end - k});
        while (end < count && p.disparity[first + end] > 0) ++end;
    }
}

// Lists the pixels of holes: of regions of fewer than `least_px` pixels without foreground. Words that have
// some are numbered, so that the sets of these pixels are small; entry 0 stands for all regions that are too
// large, which need not be told apart.
template <typename Team>
HEXRELIEF_TEAM void list_holes(const Team& team, const PixelArrays& p, unsigned least_px) {
    const SharedSets sets{p.roots};
    const unsigned per_row = hole_words_per_row(p.width), width = static_cast<unsigned>(p.width);
    const auto entry = [&](unsigned word, unsigned bit) { return p.numbers[word] * kHoleWord + bit + 1; };
    const auto is_empty = [&](unsigned i) { return !(p.disparity[i] > 0); };
    // Calls visit(word, run) for all runs, followed by a barrier.
    const auto each_run = [&](unsigned words, const auto& visit) {
        team.each(words, [&](std::size_t k) {
            const unsigned word = p.words[k];
            each_hole_run(p, word, [&](const HoleRun& run) { visit(word, run); });
        });
    };
    if (team.is_first()) p.roots[0] = 0;
    team.each(hole_words(p.width, p.height), [&](std::size_t k) {
        const unsigned word = static_cast<unsigned>(k);
        bool is_numbered = false;
        each_hole_run(p, word, [&](const HoleRun& run) {
            if (!is_numbered) p.words[p.numbers[word] = add_to(&p.counts->words, 1)] = word;
            is_numbered = true;
            const unsigned own = entry(word, run.bit);
            for (unsigned bit = 0; bit < run.count; ++bit)
                p.roots[own + bit] = run.count < least_px ? own : 0;
            p.areas[own] = 0;
        });
    });
    const unsigned words = p.counts->words;
    each_run(words, [&](unsigned word, const HoleRun& run) {
        const unsigned own = entry(word, run.bit);
        if (run.first % width != 0 && run.bit == 0 && is_empty(run.first - 1))
            sets.join(entry(word - 1, kHoleWord - 1), own);
        for (unsigned k = 0; run.first >= width && k < run.count; ++k) {
            const unsigned above = run.first + k - width;
            if (is_empty(above) && (k == 0 || !is_empty(above - 1)))
                sets.join(entry(word - per_row, run.bit + k), own);
        }
    });
    each_run(words, [&](unsigned word, const HoleRun& run) {
        const unsigned root = sets.root(entry(word, run.bit));
        if (root != 0 && load(p.areas + root) < least_px) add_to(p.areas + root, run.count);
    });
    each_run(words, [&](unsigned word, const HoleRun& run) {
        const unsigned root = sets.root(entry(word, run.bit));
        if (root == 0 || p.areas[root] >= least_px) return;
        const unsigned at = add_to(&p.counts->pending, run.count);
        for (unsigned k = 0; k < run.count; ++k) p.pending[at + k] = run.first + k;
    });
}

// Lists the pixels of speckles: of regions of fewer than kLeastRegion_px pixels between discontinuities. Each
// is found from its last pixel, which has none of its region on its right or below.
template <typename Team>
HEXRELIEF_TEAM void list_speckles(const Team& team, const PixelArrays& p) {
    const unsigned width = static_cast<unsigned>(p.width), pixels = static_cast<unsigned>(p.pixels());
    const auto goes_right = [&](unsigned i) {
        return (i + 1) % width != 0 && !(p.flags[i] & kDiscontinuityRight);
    };
    const auto goes_down = [&](unsigned i) {
        return i + width < pixels && !(p.flags[i] & kDiscontinuityDown);
    };
    const auto list_speckle = [&](unsigned last) {
        if (goes_right(last) || goes_down(last)) return;
        unsigned region[kLeastRegion_px] = {last}, count = 1;
        bool is_last = true;
        const auto add = [&](unsigned i) {
            is_last = is_last && i <= last;
            for (unsigned k = 0; k < count; ++k)
                if (region[k] == i) return;
            if (count < kLeastRegion_px) region[count++] = i;
        };
        for (unsigned k = 0; k < count && count < kLeastRegion_px; ++k) {
            const unsigned i = region[k];
            if (goes_right(i)) add(i + 1);
            if (i % width != 0 && goes_right(i - 1)) add(i - 1);
            if (goes_down(i)) add(i + width);
            if (i >= width && goes_down(i - width)) add(i - width);
        }
        if (!is_last || count == kLeastRegion_px) return;
        const unsigned at = add_to(&p.counts->pending, count);
        for (unsigned k = 0; k < count; ++k) p.pending[at + k] = region[k];
    };
    team.each_block(p.width, p.height, [&](int x0, int y) {
        const unsigned first = static_cast<unsigned>(y) * width + static_cast<unsigned>(x0),
                       end = first + static_cast<unsigned>(min_of(Team::kBlock, p.width - x0));
        std::uint8_t any = end % width == 0 ? kDiscontinuityRight : 0;
        for (unsigned i = first; i < end; ++i) any |= p.flags[i];
        if (!(any & kDiscontinuityRight)) return;
        for (unsigned i = first; i < end; ++i) list_speckle(i);
    });
}

// Gives the pending pixels disparities, from their regions' borders inwards, a ring per round.
template <typename Team>
HEXRELIEF_TEAM void absorb(Team& team, const PixelArrays& p, Around kind) {
    const unsigned count = p.counts->pending;
    team.each(count, [&](std::size_t k) { p.flags[p.pending[k]] = kUnsettled; });
    for (bool more = true; more;) {
        bool is_any_found = false;
        team.each(count, [&](std::size_t k) {
            const unsigned i = p.pending[k];
            float found = nothing(kind);
            if (p.flags[i] == kUnsettled)
                each_neighbour(p, i, [&](unsigned j) {
                    if (p.flags[j] != kUnsettled) found = taken(found, p.disparity[j], kind);
                });
            p.found[k] = found;
            is_any_found = is_any_found || found != nothing(kind);
        });
        more = team.any(is_any_found);
        team.each(count, [&](std::size_t k) {
            if (p.found[k] == nothing(kind)) return;
            p.disparity[p.pending[k]] = p.found[k];
            p.flags[p.pending[k]] = 0;
        });
    }
}

// Returns those of `steps` from pixel i = (x, y) that are discontinuities.
HEXRELIEF_HD std::uint8_t discontinuities_of(const PixelArrays& p, std::size_t i, int x, int y, int steps,
                                             float least) {
    int found = steps;
    for (int down = 0; down < 2; ++down) {
        const int flag = down ? kDiscontinuityDown : kDiscontinuityRight;
        if ((steps & flag) &&
            !is_discontinuity_of_step(p.disparity + i, {x, y, down}, p.width, p.height, least))
            found &= ~flag;
    }
    return static_cast<std::uint8_t>(found);
}

template <typename Team>
HEXRELIEF_TEAM void find_discontinuities(const Team& team, const PixelArrays& p, float least) {
    team.each_block(p.width, p.height, [&](int x0, int y) {
        const std::size_t first = static_cast<std::size_t>(y) * p.width + x0;
        const float* const d = p.disparity + first;
        const float* const below = y + 1 < p.height ? d + p.width : d;
        std::uint8_t* const flags = p.flags + first;
        const int count = min_of(Team::kBlock, p.width - x0), inner = min_of(count, p.width - 1 - x0);
        // An integer, so that the loop vectorises; the row's last pixel has none beside it.
        int any = inner < count ? is_discontinuity(d[inner], below[inner], least) : 0;
        for (int k = 0; k < inner; ++k)
            any |= is_discontinuity(d[k], d[k + 1], least) | is_discontinuity(d[k], below[k], least);
        for (int k = 0; k < count; ++k) flags[k] &= kTrusted;
        for (int k = 0; any != 0 && k < count; ++k) {
            const int steps = steps_at(d[k], d[k < inner ? k + 1 : k], below[k], least);
            if (steps != 0) flags[k] |= discontinuities_of(p, first + k, x0 + k, y, steps, least);
        }
    });
}

// Does the same where it may change with the disparities of the pending pixels.
template <typename Team>
HEXRELIEF_TEAM void find_discontinuities_again(const Team& team, const PixelArrays& p, float least) {
    constexpr int kAcross = kDiscontinuitiesLeft_px + 1 + kDiscontinuitiesRight_px,
                  kDown = kDiscontinuitiesAbove_px + 1 + kDiscontinuitiesBelow_px, kAll = kAcross + kDown;
    const std::size_t count = p.counts->pending;
    // Pixel by pixel takes longer than row by row.
    if (count * 4 * kAll > p.pixels()) return find_discontinuities(team, p, least);
    team.each(count * kAll, [&](std::size_t k) {
        const unsigned pending = p.pending[k / kAll], width = static_cast<unsigned>(p.width);
        const int at = static_cast<int>(k % kAll);
        int x = static_cast<int>(pending % width), y = static_cast<int>(pending / width);
        if (at < kAcross)
            x += at - kDiscontinuitiesLeft_px;
        else
            y += at - kAcross - kDiscontinuitiesAbove_px;
        if (x < 0 || y < 0 || x >= p.width || y >= p.height) return;
        const std::size_t i = static_cast<std::size_t>(y) * width + x;
        const float* const d = p.disparity + i;
        const int steps = steps_at(*d, x + 1 < p.width ? d[1] : *d, y + 1 < p.height ? d[width] : *d, least);
        store(p.flags + i, static_cast<std::uint8_t>((load(p.flags + i) & kTrusted) |
                                                     discontinuities_of(p, i, x, y, steps, least)));
    });
}

// Counts the pixels with a discontinuity by tiles, as sums over all tiles above and to the left.
template <typename Team>
HEXRELIEF_TEAM void sum_tiles(const Team& team, const PixelArrays& p) {
    static_assert(kTile_px == 4 && (kDiscontinuityRight | kDiscontinuityDown) == 3);
    const std::size_t columns = tile_sum_count(p.width), rows = tile_sum_count(p.height);
    team.each(columns * rows, [&](std::size_t k) {
        const int x = static_cast<int>(k % columns) * kTile_px - kTile_px,
                  y0 = static_cast<int>(k / columns) * kTile_px - kTile_px;
        std::uint32_t counts = 0;  // one byte for each of the tile's columns
        for (int y = y0; x >= 0 && y >= 0 && y < min_of(y0 + kTile_px, p.height); ++y) {
            std::uint32_t four;
            std::memcpy(&four, p.flags + static_cast<std::size_t>(y) * p.width + x, sizeof four);
            counts += (four | four >> 1) & 0x01010101u;
        }
        const int beyond = max_of(0, x + kTile_px - p.width);
        p.tile_sums[k] = (counts << 8 * beyond) * 0x01010101u >> 24;
    });
    team.sum_lines(p.tile_sums, rows, columns, columns, 1);
    team.sum_lines(p.tile_sums, columns, 1, rows, columns);
}

struct PixelRules {
    float background_px,
        discontinuity_px;  // least disparity of the foreground, least height of a discontinuity
    float step_px;         // the same, infinite if all are bridged
    unsigned hole_px;      // number of pixels from which on a hole stays
};

inline PixelRules pixel_rules(const SurfaceConfig& config, float background_px, double cell_px) {
    const float own = static_cast<float>(config.least_discontinuity_px),
                px = own > 0 ? own : kDiscontinuity_px;
    return {background_px, px, config.discontinuities == Discontinuities::bridge ? HUGE_VALF : px,
            static_cast<unsigned>(clamp_to(std::ceil(cell_px), 1.0, 1e9))};
}

// Fills all arrays. Holes take the farther disparity around them, speckles the nearer one; holes come first,
// because surfaces torn apart by them would become speckles.
template <typename Team>
HEXRELIEF_TEAM void find_pixel_surfaces(Team& team, const PixelArrays& p, const PixelRules& rules) {
    if (team.is_first()) *p.counts = {};
    clean_pixels(team, p, rules.background_px, rules.step_px);
    list_holes(team, p, rules.hole_px);
    absorb(team, p, Around::hole);
    if (team.is_first()) p.counts->pending = 0;
    find_discontinuities(team, p, rules.step_px);
    list_speckles(team, p);
    absorb(team, p, Around::speckle);
    find_discontinuities_again(team, p, rules.step_px);
    sum_tiles(team, p);
}

}  // namespace hexrelief::step
