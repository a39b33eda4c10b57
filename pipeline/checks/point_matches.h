// Finds points of the left view in the right one, also above and below their row.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/data/image.h"

namespace hexrelief::checks {

// A grey image: row-major, top row first.
struct GreyImage {
    int width = 0, height = 0;
    std::vector<std::uint8_t> values;

    std::uint8_t at(int x, int y) const { return values[static_cast<std::size_t>(y) * width + x]; }
};

GreyImage grey_of(const Image& image);

// A search for a point of the left view: at right(x - disparity, y + row), for all disparities and rows
// within the reach of the expected disparity and of row 0.
struct PointSearch {
    int x = 0, y = 0;
    int disparity_px = 0, reach_px = 0, row_reach_px = 0;
};

// A match: left(x, y) is right(x - disparity_px, y + row_px).
struct PointMatch {
    int x = 0, y = 0;
    int disparity_px = 0;
    double row_px = 0;
};

// Returns the points of a grid of about `cells` cells that allow one row to be told from the next: the
// strongest edge across the rows in each cell.
std::vector<PointSearch> find_points(const GreyImage& left, int cells);

// Returns the points that have a clear best match by normalised correlation, at one row only.
std::vector<PointMatch> match_points(const GreyImage& left, const GreyImage& right,
                                     const std::vector<PointSearch>& searches, int threads);

inline constexpr double kAgree_px = 1;  // points that differ by no more agree

// The rows' offset as a plane over the picture, fitted to most of the points.
struct RowFit {
    int points = 0;
    double agreeing_share = 0;  // share of the points that agree with the plane
    double center_px = 0, per_column = 0, per_row = 0;
    double largest_px = 0;  // largest absolute offset, at a corner of the picture
    double center_x = 0, center_y = 0;

    double at(double x, double y) const {
        return center_px + per_column * (x - center_x) + per_row * (y - center_y);
    }
};

RowFit fit_rows(const std::vector<PointMatch>& matches, int width, int height);

}  // namespace hexrelief::checks
