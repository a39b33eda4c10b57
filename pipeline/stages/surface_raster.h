// Rasterises triangles: the nearest surface's disparity at each pixel centre of a view.
#pragma once

#include <algorithm>
#include <functional>
#include <limits>
#include <vector>

#include "pipeline/base/uninitialized_vector.h"
#include "pipeline/data/surface_mesh.h"

namespace hexrelief::stages {

// A point of a view: x, y in px (the centre of pixel (i, j) is (i + 0.5, j + 0.5)), and its
// disparity d in px.
struct ViewPoint {
    double x = 0, y = 0, d = 0;
};

// The triangles as one camera sees them, of either orientation; those without area cover nothing.
struct View {
    std::vector<ViewPoint> points;
    const std::vector<Triangle>* triangles;
    int width, height;  // size of the image, px
};

inline constexpr double kNotCovered = -std::numeric_limits<double>::infinity();
using Disparities = RawVector<double>;

// Returns one disparity per pixel, row-major: the largest of all triangles that contain the pixel's centre,
// their edges included; kNotCovered if none does. Disparity is linear over a triangle, which is exact for
// planes in space. The result is the same for any number of threads (>= 1).
Disparities rasterise_disparity(const View& view, int threads);
// Returns 1 for each pixel, row-major, that has a disparity then.
std::vector<char> rasterise_coverage(const View& view, int threads);
// Raises the disparities that such triangles show so far, of the same size, to those of more triangles.
void rasterise_over(Disparities& shown, const View& view, int threads);

// The pixels x .. x + count - 1 of row y whose centres lie in a triangle.
struct PixelRun {
    int x, y, count;
    // Disparity of the triangle's plane at the first pixel, and its increase per pixel.
    double first, slope;
    double low, high;  // the triangle's smallest and largest disparity, which bound the rounded values
    double disparity(int i) const { return std::clamp(first + slope * i, low, high); }
};
// Calls take(run) for the rows 0, row_step, 2 * row_step and so on of one triangle after another. A pixel in
// several triangles comes several times.
void scan_pixels(const View& view, int row_step, const std::function<void(const PixelRun&)>& take);

// Fills pixels near the triangles: each pixel of `wanted` (row-major, one value per pixel) that `covered`
// leaves open, but whose centre is within slack_px (at most 1) of a triangle, gets the disparity of the
// nearest point of all triangles; the largest disparity if several points are equally near.
void fill_within(Disparities& covered, const std::vector<char>& wanted, const View& view, double slack_px,
                 int threads);

// Calls work(first_row, last_row + 1) for bands of rows on `threads` threads; returns when all are done.
void for_row_bands(int height, int threads, const std::function<void(int, int)>& work);

}  // namespace hexrelief::stages
