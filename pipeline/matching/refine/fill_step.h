// Fills a pixel without a match from the nearest matches in eight directions.
#pragma once

#include <cstdint>

#include "pipeline/base/host_device.h"
#include "pipeline/matching/refine/consistency_step.h"
#include "pipeline/matching/refine/match_color_step.h"
#include "pipeline/matching/refine/slope_step.h"

namespace hexrelief::step {

inline constexpr int kDirections = 8;
// The order of the directions behind these does not matter.
inline constexpr int kEast = 0, kNorthEast = 1, kSouthEast = 2;
// The steps along x and y of direction k: E, NE, SE, N, S, W, NW, SW.
HEXRELIEF_HD int direction_x(int k) {
    return k < 3 ? 1 : k < 5 ? 0 : -1;
}
HEXRELIEF_HD int direction_y(int k) {
    constexpr int kRows[kDirections] = {0, -1, 1, -1, 1, 0, -1, 1};
    return kRows[k];
}
inline constexpr int kLongestExtension_px = 16;  // a match's plane is followed no farther

HEXRELIEF_HD int cut_extension(int distance_px) {
    return distance_px > kLongestExtension_px    ? kLongestExtension_px
           : distance_px < -kLongestExtension_px ? -kLongestExtension_px
                                                 : distance_px;
}

// Returns the disparity that the plane through a known pixel has (dx, dy) px away from it.
HEXRELIEF_HD int on_plane(std::int16_t disparity, std::int16_t slope_x, std::int16_t slope_y, int dx,
                          int dy) {
    const int at =
        disparity + (plane_change<int>(slope_x, slope_y, cut_extension(dx), cut_extension(dy)) >> 4);
    return at > 0 ? at : 0;
}

// With at least this many candidates, the farthest one may be a wrong match.
inline constexpr int kManyCandidates = 5;
// The least advantage in the difference of colours, a sum over 3x3 pixels, that makes a
// candidate the better one.
inline constexpr int kClearlyMoreAlike = 9 * 12;

// The position of a pixel, and the right view's row.
struct FillSite {
    int x, width, min_px;
    const std::int32_t* nearest_seen;
    const std::int16_t* right;  // trusted matches of the right view
};

HEXRELIEF_HD void insert_sorted(int values[], int& count, int value) {
    int i = count++;
    for (; i > 0 && values[i - 1] > value; --i) values[i] = values[i - 1];
    values[i] = value;
}

// The frame rule: if the surface to the right matches beyond the right picture's left edge, so does this
// pixel. Returns the median of those candidates E, NE and SE that do; kUnknown16 if the rule does not apply.
HEXRELIEF_HD int beyond_frame(const FillSite& site, const int candidates[kDirections]) {
    int values[3], count = 0;
    for (int k = kEast; k <= kSouthEast; ++k) {
        if (candidates[k] < 0) continue;
        const bool outside = beyond_left_edge(site.x, site.min_px, candidates[k]);
        if (outside) insert_sorted(values, count, candidates[k]);
        if (k == kEast && !outside) return matching::kUnknown16;
    }
    return count > 0 ? values[count / 2] : matching::kUnknown16;
}

// Returns the candidate whose match has the pixel's colours, if they are clearly more similar than those of
// the guess's match; else the guess. A guess outside of the right picture has no match. Of equally good
// candidates the farthest one is chosen.
template <typename Difference>
HEXRELIEF_HD int alike_candidate(const FillSite& site, const int visible[], int count, int guess,
                                 const Difference& difference) {
    int best = guess, least = INT32_MAX, of_guess = INT32_MAX;
    for (int i = 0; i < count; ++i) {
        if (!is_in_right(site.x, site.width, site.min_px, visible[i])) continue;
        if (i > 0 && visible[i] == visible[i - 1]) continue;
        const int here = difference(visible[i]);
        of_guess = visible[i] == guess ? here : of_guess;
        if (here >= least) continue;
        least = here;
        best = visible[i];
    }
    return least <= of_guess - kClearlyMoreAlike ? best : guess;
}

// Returns the disparity of an unmatched pixel. candidates: for each direction, the disparity at the pixel of
// the nearest match's plane; < 0 = no match in that direction. difference(disparity): difference of colours
// between the 3x3 pixels around the pixel and those around its match in the right picture.
//
// The visibility rule excludes candidates in front of the surface that the right camera sees, if there are
// others. The median of the rest is returned if one of them agrees with the right view's match. Otherwise, if
// the right camera sees something in front of the farthest one, the pixel is hidden. What hides it lies to
// its right, and matches in the east mostly beyond that: the farthest one from elsewhere that is hidden, too,
// is returned, or else the farthest one. Otherwise nothing hides the pixel, it was merely not matched: it may
// belong to any of the surfaces around it, and the right picture's colours decide.
template <typename Difference>
HEXRELIEF_HD std::int16_t filled(const FillSite& site, const int candidates[kDirections],
                                 const Difference& difference) {
    const int outside = beyond_frame(site, candidates);
    if (outside >= 0) return static_cast<std::int16_t>(outside);
    int values[kDirections], count = 0, farthest = INT16_MAX, hidden = INT16_MAX;
    bool matched = false;
    for (int k = 0; k < kDirections; ++k) {
        const int d = candidates[k];
        if (d < 0) continue;
        farthest = d < farthest ? d : farthest;
        const int column = matching_column(site.x, site.min_px, d);
        const bool inside = column >= 0 && column < site.width;
        if (inside && hides(site.nearest_seen[column], d)) continue;
        insert_sorted(values, count, d);
        if (k > kSouthEast && d < hidden && inside && is_hidden(site.nearest_seen[column], d)) hidden = d;
        matched = matched || agreed(static_cast<std::int16_t>(d), site.right, column, site.width,
                                    matching::kOnePixel) != matching::kUnknown16;
    }
    if (count == 0) return farthest < INT16_MAX ? static_cast<std::int16_t>(farthest) : matching::kUnknown16;
    if (matched) return static_cast<std::int16_t>(values[count / 2]);
    const int column = matching_column(site.x, site.min_px, values[0]);
    if (column >= 0 && column < site.width && is_hidden(site.nearest_seen[column], values[0]))
        return static_cast<std::int16_t>(hidden < INT16_MAX ? hidden : values[0]);
    const int guess = values[count >= kManyCandidates ? 1 : 0];
    return static_cast<std::int16_t>(alike_candidate(site, values, count, guess, difference));
}

}  // namespace hexrelief::step
