// Triangles over an image plane -> the nearest surface's disparity at each pixel centre.
#pragma once

#include <algorithm>
#include <functional>
#include <limits>
#include <vector>

#include "pipeline/data/surface_mesh.h"

namespace hexrelief::stages {

// x, y in px of one view (centre of pixel (i, j) = (i + 0.5, j + 0.5)), d its disparity in px.
struct ViewPoint {
    double x = 0, y = 0, d = 0;
};

// Triangles as one camera sees them, of either orientation; those without area cover nothing.
struct View {
    std::vector<ViewPoint> points;
    const std::vector<Triangle>* triangles;
    int width, height;  // of the image, px
};

inline constexpr double kNotCovered = -std::numeric_limits<double>::infinity();

// One disparity a pixel, row-major: the largest of all triangles that hold the pixel's centre, their edges
// included; kNotCovered where there is none. Disparity is linear over a triangle, which is exact for planes
// in space. The same for any number of threads (>= 1).
std::vector<double> rasterise_disparity(const View& view, int threads);

// The pixels x .. x + count - 1 of row y, whose centres lie in a triangle.
struct PixelRun {
    int x, y, count;
    double first,
        slope;         // the disparity of the triangle's plane at the first of them, and by how much it grows
    double low, high;  // the triangle's smallest and largest disparity, which rounding must not leave
    double disparity(int i) const { return std::clamp(first + slope * i, low, high); }
};
// Calls take(run) for one triangle after another, of the rows 0, row_step, 2 * row_step and so on. A pixel in
// several triangles comes several times.
void scan_pixels(const View& view, int row_step, const std::function<void(const PixelRun&)>& take);

// Gives every pixel of `wanted` (row-major, one a pixel) that `covered` leaves open, but whose centre is
// within slack_px (at most 1) of a triangle, the disparity of the nearest point of all triangles; of several
// as near, the largest.
void fill_within(std::vector<double>& covered, const std::vector<char>& wanted, const View& view,
                 double slack_px, int threads);

// Calls work(first_row, last_row + 1) for bands of rows on `threads` threads; returns when all are done.
void for_row_bands(int height, int threads, const std::function<void(int, int)>& work);

}  // namespace hexrelief::stages
