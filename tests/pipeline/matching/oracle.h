// What the matcher must make of a pair, by a slow and plain program that shares no code with
// pipeline/matching. Each step of the recipe is a function of its own.
//
// WORDS. Disparities are in 1/16 px above min_px; -1 is unknown, and so is everything outside of the picture.
// "Rounded" goes to the nearest whole number, halves upwards; "cut down" goes to the next one below. A colour
// step between two pixels is the largest difference of a channel. Of an even number of values, the median is
// the larger of the two in the middle.
//
//  1. Colours. A pair whose pictures differ in channels is taken as grey. Grey of a colour picture is
//     (9798 red + 19235 green + 3735 blue) / 2^15, rounded.
//  2. Costs of a match, at the disparities that the pixel's window has (16). 255 from the range's end on,
//     else of left pixel (x, y) and right pixel (x - d, y), the latter moved to the edge where it lies
//     outside. A census says of each of the other pixels of a 9x7 window (outside: the nearest one inside),
//     whether it is darker than the middle one, in grey. 3 times the number of places where the two censuses
//     differ, and the differences of the channels, each at most 40: an eighth of the sum of three, or half of
//     the one, cut down.
//  3. Paths come from the left, the right, above and below. A path's cost at a disparity is the match's cost,
//     and the least of these at the pixel before, less the least cost there: the cost at this disparity; p1
//     more than at one 1 px away; p2 more than the least. No path comes from disparities that the window
//     there has not. Nothing comes before the first pixel. p2 falls with the colour step c between the two
//     pixels in the left picture: p2 - (p2 - (p1 + 1)) c / 25, the quotient without its fraction, and at
//     least p1 + 1.
//  4. Winners have the least sum of four paths' costs, and the smaller disparity where two have, of those of
//     the range that the window has. For the right view, candidates are the left pixels that match the right
//     one; unknown where there is none. Between 16ths of a px lies the vertex of the parabola through the
//     sums at the disparities beside, in the same view, rounded, halves away from zero; not at the range's
//     ends, nor where a pixel beside is outside of the picture, or its window without the disparity.
//  5. Medians of 3x3 pixels. An unknown one counts as the middle one; an unknown middle stays.
//  6. Trust. A match's pixel in the other view lies (disparity / 16, rounded) px away. A left pixel is
//     unknown if the right one there is unknown or differs by more than the limit; none is, where limit < 0.
//     Then pixels of patches of 4-neighbours that differ by at most speckle_step become unknown if the patch
//     has at most speckle_pixels, or four times as many where the pixel is below least. A right pixel is
//     unknown if the left one is unknown or differs by more than the limit, or by more than 16 where
//     limit < 0. The right camera's nearest at a pixel is the largest disparity of the pixel and those on its
//     left and right, if all three are known; else anything.
//  7. Slopes, in 1/256 px a px. Along x, and along y: the line of least squares through the known pixels on
//     both sides, as far as they follow each other without a change of more than 20, 4 at most on a side;
//     rounded and clamped to 512 either way, and 0 of fewer than 4 pixels. Then the rounded mean over those
//     pixels of 5x5, an even number of steps along the axes away, that differ from the middle one by at most
//     24. Of unknown ones: nothing.
//  8. Filling of unknown pixels. In eight directions the nearest known pixel's plane is followed to the
//     pixel, but along each axis no farther than 16 px: cut down, and at least 0. These are the candidates.
//     Frame: where the one in the east matches less than 0.5 px right of the right picture's first pixel, or
//     farther left, or where there is none in the east, it is the median of those of east, north-east and
//     south-east that match so far left, if there are any.
//     Else: a candidate is in front where it is more than 16 above the right camera's nearest at its pixel.
//     Where all are in front: the farthest. Where there are others: their median, if one of them differs by
//     at most 16 from the right pixel that it matches; else the farthest of them, if it is more than 16 below
//     the right camera's nearest at its pixel, where that is known. Else the guess is the second farthest of
//     at least five, or the farthest. It gives way to the one with the least difference of colours (of equal
//     ones the farthest), if its own is more by at least 108, or if the guess's match is outside; those whose
//     match is outside do not count. A difference of colours is the sum over 3x3 pixels of the left picture,
//     and those as far from the match, the nearest inside for those outside, of step 12's.
//  9. Discontinuities are steps of more than 24 between 4-neighbours, both known. `near`: pixels that have
//     one of these two within 2 px along both axes.
// 10. Votes on a pixel that has a window: of 9x9 pixels, every seventh along both axes (hole), or of its
// 13x13
//     neighbours those an even number of steps along the axes away (near). A vote is where the voter's plane
//     lies at the pixel: the change cut down, the vote at least 0. Its weight: (32 - colour step)^2 / 16, 0
//     from a step of 32 on (hole: the square of that by 64, where colours are the rounded means of 3x3
//     pixels, the nearest inside for those outside); times 16 exp(-(r / 7)^2) (near) or 16 exp(-(r / 4)^2)
//     (hole), rounded, r the larger of the steps along the axes; times the voter's own weight; by 32; each
//     cut down. None, if it is in front as in step 8. The least vote is taken up to which votes have at least
//     half of the weight; the pixel is left alone where none has any.
// 11. Smoothing along planes, thrice, over 5x5 pixels 1, 2, then 4 px apart. A pixel's weight is
//     (3 - |i|) (3 - |j|) (44 - |off|), 0 from 44 on and where the colour step is more than 20; off is how
//     far it lies above the plane through the middle with the mean of both pixels' slopes (the plane's change
//     rounded). The pixel moves by the rounded mean of these, to 0 at least.
// 12. Sides. At a pixel, two other surfaces: the least and the largest disparity of the known ones of 3x3
//     pixels, where that is more than 24 off its own. A disparity's match lies at 16 (x - min_px) - d
//     sixteenths of a px from the right picture's first column, between two columns, whose colours are mixed
//     and rounded; its difference is the sum of the channels', each at most 40, of grey thrice the one. Of
//     the other surfaces those count whose match is inside (at most at the last column), which are not in
//     front as in step 8. The pixel takes the one with the less difference (of equal ones the farther) if
//     that is less than its own by more than 20. It stays if its own match is outside, or more than 16 below
//     the right camera's nearest there, if that is known.
// 13. The whole. Trusted matches; slopes, filling, and segments (15). Votes, first with windows `near`, but
//     `hole` where a pixel was filled, and weights 6 where matched, 1 where filled, but 3 where the filled
//     pixel matches as far left as in step 8, and 4 where it matches inside, in a picture in colour, with a
//     difference of colours (step 8) of at most 135, and is within 16 of the right camera's nearest there, if
//     that is known; then `near` and equal weights of 6. Sides, and once more. Medians. Smoothing with slopes
//     of the medians.
// 14. Half size, of the matcher's own winners. Pictures of (width + 1) / 2 x (height + 1) / 2 pixels, each
//     the rounded mean of 2x2 pixels, the nearest inside for those outside; the disparities searched are the
//     whole numbers from half of the least to half of the largest, rounded outwards. Steps 1 to 6, and 16,
//     with the same settings, but half of least, cut down. Then an unknown left pixel (x, y) of step 6 at
//     full size takes twice the disparity (in px) of (x / 2, y / 2) at half size, if that and its eight
//     neighbours are known there, the doubled disparity is at least min_px, and the right pixel that it leads
//     to is inside, and unknown or at most 24 off. It counts as filled.
// 15. Segments beside the frame, of the left picture with the channels that it has. Square cells of 1/150 of
//     the longer side, rounded, at least 1 px, that lie in it wholly. A cell says what its middle pixel (the
//     second of two) was filled with, if that was not matched (14 included). Of the cells' columns the first
//     n count, where n - 1 is how often a cell is as wide as min_px + count, 0 at least, cut down. A cell's
//     colour: the rounded mean of its pixels and of those around it, the nearest inside for those outside, in
//     1/16 level. The step between two cells: the root of the sum of the channels' squares, cut down. Pairs
//     of neighbours (of 8) in order of their steps; of equal ones that of the first cell, row by row, and of
//     its neighbours E, SW, S, SE. First each pair's two segments become one where for both the step, less
//     the largest by which cells of the segment were joined, times the cells in it, is at most 150 levels.
//     Then, in the same order, where one of both has fewer cells than 1/120 of those that count, cut down. A
//     segment with at most one matched cell to 20 unmatched ones has at least the disparity that is the
//     number 3 (n - 1) / 4, cut down, from 0 on, of its n unmatched cells' in order: pixels of its cells that
//     were filled farther take that.
// 16. Windows. A pixel's window has two runs of disparities, which begin so many px above min_px: the far
//     and the near one. Where the range has at most 64 they are 32 long and begin at 0 and 32. Else they are
//     16 long, and come from the left view's winners (4) at half size (14), in px at full size above min_px,
//     cut down: those of the 5x5 pixels around (x / 2, y / 2) there that are inside. Where the least and the
//     largest differ by at most 20, the far run begins 14 below half of their sum (without its fraction), cut
//     down to a whole number of fours, and the near one 16 above that. Else one begins 6 below the middle
//     pixel's own, and one 6 below the one of both that is farther from its own (the largest, if both are as
//     far), both cut down to fours; the far one is the lower. Then both move into the range, rounded up to
//     fours: the far one, so that 32 have room from there on, and the near one, so that it begins at least 16
//     above that and has room.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "pipeline/data/disparity_map.h"

namespace hexrelief::oracle {

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
    Grid far, near;  // the first disparities
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
Planes slopes(const Grid& map);                                                                       // 7
Grid fill(const Trusted& matches, const Planes& slopes, const Pictures& pictures, int min_px);        // 8
Grid near_windows(const Grid& map);                                                                   // 9
Grid votes(const Voters& voters, const Picture& left, const Grid& windows);                           // 10
Grid smooth(const Grid& map, const Picture& left);                                                    // 11
Grid sides(const Grid& map, const Pictures& pictures, const Grid& nearest, int min_px);               // 12
Views match_views(const StereoPair& pair, const Settings& settings);  // 1 to 4, and 16
Runs search_runs(const StereoPair& pair, const Settings& settings);   // 16
// 16, of a picture of this size, from the winners at half size.
Runs runs_around(const Grid& half, int width, int height, const Settings& settings);
int searched_end(const Settings& settings);        // beyond the last disparity that a window may have
StereoPair half_pair(const StereoPair& pair);      // 14
Settings half_settings(const Settings& settings);  // 14
HalfSize match_at_half_size(const StereoPair& pair, const Settings& settings);  // 14
void raise_segments(const Grid& matches, const Picture& left, const Settings& settings,
                    Grid& filled);  // 15
// 5 to 13 and 15, and 14 with half_size, which may be null.
Result refine(const StereoPair& pair, const Views& winners, const HalfSize* half_size,
              const Settings& settings);

int cut_down(int numerator, int denominator);  // denominator > 0
int rounded(int numerator, int denominator);

}  // namespace hexrelief::oracle
