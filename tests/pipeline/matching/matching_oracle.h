// The recipe that the matcher must follow, and a slow, plain program for it that shares no code with
// pipeline/matching. Each step of the recipe is a function.
//
// Terms:
// - Disparities are integers in 1/16 px above min_px, except in steps 2 to 4 and 16, which count whole px
//   above min_px. Nearer means a larger disparity, farther a smaller one. -1 is unknown, and everything
//   outside the picture is unknown.
// - min_px, count, p1, p2, limit, speckle_pixels, speckle_step and least are those of Settings.
// - round() gives the nearest integer, halves upwards; floor() gives the next integer below (the function
//   cut_down()); trunc() drops the fraction.
// - The colour step of two pixels is the largest absolute difference of a channel.
// - The median of an even number of values is the larger one of the two in the middle.
// - Clamped: a pixel outside the picture is replaced by the nearest one inside.
//
//  1. Colours. If the pictures have different numbers of channels, both are used as grey. The grey of a
//     colour picture is round((9798 red + 19235 green + 3735 blue) / 2^15).
//  2. Costs of a match, for each disparity d of the pixel's window (step 16). At d >= count the cost is
//     255. Below that, left pixel (x, y) is compared with right pixel (x - min_px - d, y), clamped, and the
//     cost is the sum of two parts:
//     - A census records for each other pixel of a 9x7 window, clamped, whether it is darker in grey than
//       the middle one. This part is 3 times the number of pixels that differ between the two censuses.
//     - The channels' absolute differences, each at most 40, are added up: floor(sum / 8) for three
//       channels, floor(sum / 2) for one.
//  3. Paths come from the left, the right, above and below. At the first pixel of a path, its cost is the
//     match's cost. Behind that, L is the path's least cost at the previous pixel, and its cost at
//     disparity d is the match's cost, minus L, plus the least of:
//     - the path's cost at the previous pixel at d;
//     - the same at d - 1 or d + 1, plus p1;
//     - L, plus max(p1 + 1, p2 - trunc((p2 - (p1 + 1)) c / 25)), with the colour step c between the two
//       pixels in the left picture.
//     No path comes from disparities outside the previous pixel's window; they do not count for L.
//  4. Winners. A pixel's winner is the disparity d below count with the least sum of the four paths'
//     costs; of equal ones, the smallest. Candidates of a left pixel are the disparities of its window.
//     Candidates of right pixel (x, y) are the d for which left pixel (x + min_px + d, y) is inside and
//     has d in its window; without candidates the pixel is unknown. The vertex of the parabola through the
//     same view's sums at d - 1, d and d + 1 gives the winner in 1/16 px, rounded, halves away from zero.
//     The winner stays at d if d is an end of the range, if one of the other two is no candidate, or if
//     the three sums are equal.
//  5. Medians of 3x3 pixels, of which unknown ones count as the middle one. As unknown is -1, an unknown
//     middle pixel becomes known if five or more of its neighbours are known.
//  6. Trusted matches, from the medians of both views. The match of a left pixel in column x is the
//     right pixel in column x - min_px - round(d / 16) of the same row. That of a right pixel is found
//     the other way round.
//     - A left pixel becomes unknown if its match is unknown or differs by more than `limit`. This is left
//       out if limit < 0.
//     - Patches are left pixels connected through 4-neighbours that differ by at most speckle_step. A pixel
//       becomes unknown if its patch has at most speckle_pixels pixels, or at most 4 times as many if the
//       pixel's disparity is below `least`.
//     - A right pixel becomes unknown if its match among the remaining left pixels is unknown or differs by
//       more than `limit`, or by more than 16 if limit < 0.
//     - `nearest` of a right pixel is the largest disparity of the pixel and those on its left and right,
//       if all three are known, else kAnything.
//     - A left pixel's disparity is in front if it is more than 16 above `nearest` at its match: such a
//       surface would hide the one that the right camera sees. It is hidden if it is more than 16 below
//       `nearest` there. It is neither if `nearest` is kAnything or the match is outside.
//  7. Slopes along x and along y, in 1/256 px per px, of known pixels:
//     - A line of least squares is fitted to the pixel and up to 4 pixels on each side. A side ends before
//       an unknown pixel, and before a change of more than 20 from one pixel to the next. The line's slope
//       is rounded and clamped to -512 .. 512; it is 0 if there are fewer than 4 pixels.
//     - The pixel's slope is the rounded mean of the lines' slopes at those known pixels of the 5x5 around
//       it, 1 or 6 px apart (near or far), that differ from it by at most 24 and are an even number of steps
//       along the axes away.
//  8. Filling of unknown pixels. Candidates are the planes of the nearest known pixels in eight directions,
//     continued to the pixel, but by no more than 16 px along each axis; the change is floored, and the
//     result is at least 0. A pixel without candidates stays unknown. The first rule that applies is used:
//     - A candidate d is beyond the frame if x - min_px - d / 16 < 0.5, that is, if it matches the right
//       picture's first column or anything left of it. If some of the candidates in the east, north-east
//       and south-east are beyond the frame, and the one in the east is one of them or missing: the median
//       of those that are beyond the frame.
//     - If all candidates are in front (step 6): the farthest. The rules below ignore those in front.
//     - If a candidate differs by at most 16 from the known right pixel that it matches: the
//       median of the candidates.
//     - If the farthest candidate is hidden (step 6): the farthest hidden one that is not from the east,
//       north-east and south-east, or else this one.
//     - Otherwise the guess is the second farthest of five or more candidates, or the farthest of fewer.
//       The candidate with the least difference of colours (of equal ones, the farthest) replaces it if the
//       guess's difference is larger by at least 108, or if the guess's match is outside. Candidates whose
//       match is outside (step 12) cannot replace it.
//     The difference of colours is the sum of step 12's over the 3x3 pixels around the left pixel and
//     around its match, clamped.
//  9. Discontinuities are steps of more than 24 between 4-neighbours that are both known. The window `near`
//     is given to the pixels that have one of the two within 1 px along both axes.
// 10. Votes on the pixels that have a window. Voters are known pixels, in `hole` 9x9 pixels that are 7 px
//     apart, in `near` those of the 13x13 pixels that are an even number of steps along the axes away.
//     - A vote is the disparity of the voter's plane at the pixel, (dx, dy) being the voter's position
//       relative to the pixel: max(0, d - floor((slope_x dx + slope_y dy) / 16)). Votes that are in front
//       at the pixel (step 6) do not count.
//     - A vote's weight is floor(likeness distance w / 32), with the voter's own weight w. With the colour
//       step s, likeness is floor((32 - s)^2 / 16), but 0 from s = 32 on. In `hole`, s is that between the
//       rounded means of 3x3 pixels, clamped, and likeness is then squared and divided by 64, floored.
//       distance is round(16 exp(-(r / 7)^2)) in `near` and round(16 exp(-(r / 4)^2)) in `hole`; r is the
//       larger of the voter's steps along the axes, of 7 px each in `hole`.
//     - The pixel takes the least vote for which it and the smaller votes have at least half of the total
//       weight. It stays unchanged if the total is 0.
// 11. Smoothing along planes, in three passes over the known ones of 5x5 pixels (i, j) that are 1, then
//     2, then 4 px apart. All passes use the slopes of the map before smoothing. `off` is the height of
//     pixel (i, j) above the plane through the middle pixel with the mean of both pixels' slopes; the
//     plane's change is rounded. The weight is (3 - |i|) (3 - |j|) (44 - |off|), but 0 if |off| >= 44 or
//     if the colour step is larger than 20. The middle pixel moves by the rounded weighted mean of `off`,
//     down to 0 at most.
// 12. Sides, the choice between the surfaces beside a pixel.
//     - The match of disparity d lies 16 (x - min_px) - d sixteenths of a px right of the right picture's
//       first column. It is inside if it is in 0 .. 16 (width - 1). Its colour is interpolated between two
//       columns and rounded. The difference of colours is the sum of the channels' absolute differences,
//       each at most 40; for grey, 3 times the only one.
//     - A pixel stays if its own match is outside or hidden (step 6).
//     - The other surfaces are the least and the largest known disparity of the 3x3 pixels, if they
//       differ from the pixel's own by more than 24. They count if their match is inside and they are not
//       in front (step 6).
//     - The pixel takes the surface with the smaller difference of colours (of equal ones, the farther) if
//       the difference is more than 20 below that of its own disparity.
// 13. The whole refinement, in this order:
//     - Trusted matches (6), additions from half size (14), far slopes (7), filling (8), segments (15). A
//       pixel is matched if it is known after step 6; all others are filled.
//     - Votes (10) on far slopes (7) with the windows `near` (9), but with `hole` at filled pixels and those
//       that are not certain (17). All others have the weight 6. Pixels with `hole` have 3 if they are
//       beyond the frame (step 8); otherwise 4 if the pictures have colours, the match is inside and neither
//       in front nor hidden, and the difference of colours of step 8 is at most 135; otherwise 1.
//     - Twice votes on near slopes with the windows `near` of the result, in which a certain pixel (17) has
//       the weight 6, an undecided one 2, and a wrong one 1.
//     - Sides (12), twice. Medians (5). Smoothing (11).
// 14. Matches at half size. Pictures have (width + 1) / 2 x (height + 1) / 2 pixels, truncated, each
//     the rounded mean of 2x2 pixels, clamped. The range contains the integers in px from half of the
//     least disparity to half of the largest, rounded outwards. The settings are the same, except for
//     half of `least`, truncated. Steps 1 to 6 and 16 give the left view's trusted matches. At full
//     size, a left pixel (x, y) that is unknown after step 6 takes twice the disparity, in px, of pixel
//     (x / 2, y / 2) at half size on these conditions: that pixel and its eight neighbours are known,
//     the doubled disparity is at least min_px, and the match at full size is inside, and is unknown or
//     differs by at most 24.
// 15. Segments beside the frame, of the left picture with all of its channels.
//     - Cells are the squares that lie wholly in the picture, with sides of 1/150 of the picture's
//       longer side, rounded, at least 1 px. Only the first 1 + floor(max(0, min_px + count) / side)
//       columns of cells are used.
//     - A cell has the disparity of its middle pixel (the second one of two). It is matched if this pixel
//       is known before step 8; filled cells that stay unknown count as matched.
//     - A cell's colour is the mean of its pixels and of the ring of pixels around it, clamped, rounded to
//       1/16 level. The step between two cells is floor(sqrt(sum of the channels' squared differences)).
//     - Pairs of 8-neighbours are sorted by their steps. Equal ones are in the order of the first cell, row
//       by row, and then of its neighbours E, SW, S, SE.
//     - First pass over the pairs: their two segments are joined if for each of them (step - largest step
//       by which its cells were joined) * (number of its cells) is at most 150 levels.
//     - Second pass, in the same order: the two segments are joined if one of them has fewer cells than
//       floor(cells used / 120).
//     - In a segment with n filled cells, at least 20 times as many as matched ones, the disparity number
//       floor(3 (n - 1) / 4), counted from 0, of the filled cells' sorted disparities becomes the least
//       one: unmatched pixels of its cells that are farther or unknown take it.
// 16. Windows. A pixel's window consists of two runs of disparities, the far one and the near one. `end` is
//     64 for ranges of at most 64 disparities, else count rounded up to a multiple of 4.
//     - In ranges of at most 64 disparities, the runs begin at 0 and 32, and both have 32 disparities.
//     - In larger ranges they have 16, and depend on the left view's winners (4) at half size (14),
//       converted to px at full size above min_px and floored: `own` is that of (x / 2, y / 2), and low and
//       high are the least and the largest of the 5x5 pixels around that one, as far as they are inside.
//     - If high - low <= 20, the far run begins at trunc((low + high) / 2) - 14, floored to a multiple of
//       4, and the near one 16 above that.
//     - Otherwise one run begins at own - 6 and the other one at low - 6 or high - 6, of low and high the
//       one farther from own, or high if both are equally far; both floored to a multiple of 4. The lower
//       run is the far one.
//     - Finally the far run's beginning is clamped to 0 .. end - 32, and then the near one's to 16 above
//       the far one's .. end - 16.
// 17. Certainty of a pixel's side. The sides of a block of 8x8 pixels, counted from the top left, are the
// least
//     and the largest disparity of its pixels at discontinuities (9). A pixel's other surfaces are the least
//     and the largest side of its block and the eight around that one, if they differ from the pixel's own
//     disparity by more than 24 and their match is inside (12) and not in front (6). Their difference is that
//     of colours (12), or 40 if they are hidden (6). A pixel is certain if it is unknown, if it has no other
//     surface, or if its own match is outside or hidden. Otherwise it is certain if its difference of colours
//     is below that of each other surface by at least 7, wrong if it is above that of one of them by at least
//     7, and else undecided.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "pipeline/data/disparity_map.h"

namespace hexrelief::matching::oracle {

constexpr int kUnknown = -1;

struct Grid {
    int width = 0, height = 0;
    std::vector<int> values;

    Grid() = default;
    Grid(int w, int h, int value) : width(w), height(h), values(static_cast<std::size_t>(w) * h, value) {}
    Grid(int w, int h, std::vector<int> v) : width(w), height(h), values(std::move(v)) {}
    bool inside(int x, int y) const { return x >= 0 && x < width && y >= 0 && y < height; }
    int& at(int x, int y) { return values[static_cast<std::size_t>(y) * width + x]; }
    int at(int x, int y) const { return values[static_cast<std::size_t>(y) * width + x]; }
    int at_or(int x, int y, int outside) const { return inside(x, y) ? at(x, y) : outside; }
    int clamped(int x, int y) const;
};

struct Picture {
    Grid grey;
    std::vector<Grid> channels;
};

struct Settings {
    int min_px = 0, count = 1, p1 = 45, p2 = 330;
    int limit = 9, speckle_pixels = 100, speckle_step = 32, least = 0;
};

struct Pictures {
    Picture left, right;
};

// Numbers of pixels and disparities, from 0 to the last that any window may have.
constexpr int kNotSearched = -1;
struct Volume {
    int width = 0, height = 0, count = 0;
    std::vector<int> values;

    int& at(int x, int y, int d) {
        return values[(static_cast<std::size_t>(y) * width + x) * static_cast<std::size_t>(count) + d];
    }
    int at(int x, int y, int d) const {
        return values[(static_cast<std::size_t>(y) * width + x) * static_cast<std::size_t>(count) + d];
    }
};

struct Views {
    Grid left, right;
};
struct Runs {
    Grid far, near;  // the runs' first disparities
    int length;
};
constexpr int kAnything = 32767;
struct Trusted {
    Grid left, right, nearest;
};
struct HalfSize {
    Grid left;  // trusted matches
    int min_px = 0;
};
struct Planes {
    Grid x, y;  // slopes
};
enum Window { none, near, hole };
struct Voters {
    Grid map, weights, nearest;
    Planes slopes;
    int min_px;
};
struct Result {
    Grid disparities, is_matched;
};

Pictures read_pictures(const StereoPair& pair);                                  // 1
Picture read_picture(const Image& image, bool as_grey);                          // 1
int color_step(const Picture& picture, int x, int y, int other_x, int other_y);  // of pixels inside
Volume match_costs(const Picture& left, const Picture& right, const Runs& runs,
                   const Settings& settings);                                                         // 2
Volume path_sums(const Picture& left, const Volume& costs, int first_row, const Settings& settings);  // 3
Views winners(const Volume& sums, const Settings& settings);                                          // 4
Grid medians(const Grid& map);                                                                        // 5
Trusted trusted_matches(const Views& winners, const Settings& settings);                              // 6
Planes slopes(const Grid& map, int stride = 1);                                                       // 7
Grid fill(const Trusted& matches, const Planes& slopes, const Pictures& pictures, int min_px);        // 8
Grid near_windows(const Grid& map);                                                                   // 9
Grid votes(const Voters& voters, const Picture& left, const Grid& windows);                           // 10
Grid smooth(const Grid& map, const Picture& left);                                                    // 11
enum Certainty { wrong, undecided, certain };
Grid certainty(const Grid& map, const Pictures& pictures, const Grid& nearest, int min_px);  // 17
Grid sides(const Grid& map, const Pictures& pictures, const Grid& nearest, int min_px);      // 12
Views match_views(const StereoPair& pair, const Settings& settings);                         // 1 to 4, and 16
Runs search_runs(const StereoPair& pair, const Settings& settings);                          // 16
// Step 16 for a picture of this size, from the winners at half size.
Runs runs_around(const Grid& half, int width, int height, const Settings& settings);
int searched_end(const Settings& settings);        // beyond the last disparity that a window may have
StereoPair half_pair(const StereoPair& pair);      // 14
Settings half_settings(const Settings& settings);  // 14
HalfSize match_at_half_size(const StereoPair& pair, const Settings& settings);  // 14
void raise_segments(const Grid& matches, const Picture& left, const Settings& settings,
                    Grid& filled);  // 15
// Steps 5 to 13 and 15, and step 14 unless half_size is null.
Result refine(const StereoPair& pair, const Views& winners, const HalfSize* half_size,
              const Settings& settings);

int cut_down(int numerator, int denominator);  // denominator > 0
int rounded(int numerator, int denominator);

}  // namespace hexrelief::matching::oracle
