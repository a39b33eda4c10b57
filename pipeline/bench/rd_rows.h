// The points of `hexrelief bench rd`, the comparison at equal bytes, and both as text and JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/stages/other_views/hole_shares.h"
#include "pipeline/stages/surface_quality.h"

namespace hexrelief::bench::rd {

// A mesh of a method: its size and its error.
struct Point {
    std::string map, method;
    double spacing_px = 0;  // of the lattice or grid; 0 = none
    int bits = 0;
    std::size_t vertices = 0, triangles = 0, bytes = 0;
    double seconds = 0;  // to make the mesh, without compression
    stages::SurfaceQuality quality;
    stages::HoleShares holes = {};
};

// Returns a figure of a method's points on one map at `bytes`: interpolated between the two nearest points on
// logarithmic scales; nothing outside the points' range.
std::optional<double> at_bytes(const std::vector<Point>& points, const std::string& method, double bytes,
                               double stages::SurfaceQuality::*figure);

// Returns the points without those of `method` that another point of the same method and map beats: no more
// bytes, and less error of both views.
std::vector<Point> without_beaten(const std::vector<Point>& points, const std::string& method);

// All methods at the bytes of one uniform grid.
struct Comparison {
    std::string map;
    double spacing_px = 0;  // spacing of that grid
    std::size_t bytes = 0;
    struct Entry {
        std::string method;
        // duo_rmse_near_px, rmse_near_px and flat_rmse_px of SurfaceQuality
        std::optional<double> duo, near, flat;
    };
    std::vector<Entry> entries;
};
Comparison compare(const std::vector<Point>& points, const Point& uniform,
                   const std::vector<std::string>& methods);

// The least error of both views among the other meshers' entries, with its method.
struct Best {
    std::string method;
    double duo;
};
std::optional<Best> best_other(const Comparison& comparison, const std::vector<std::string>& others);

// The geometric mean, over the comparisons at grids of spacing_px, of the ratio between the method's error of
// both views and the best other mesher's.
struct Mean {
    std::string method;
    double spacing_px = 0;
    // maps_below: those on which the method is better than the best other mesher.
    int maps = 0, maps_below = 0;
    double share = 0;
};
std::optional<Mean> mean_share(const std::vector<Comparison>& comparisons, const std::string& method,
                               const std::vector<std::string>& others, double spacing_px);

// Returns the meaning of the columns, and their names.
std::string headings();
std::string point_text(const Point& point);
std::string comparison_text(const Comparison& comparison, const std::vector<std::string>& others);
std::string mean_text(const Mean& mean);

nlohmann::ordered_json point_json(const Point& point);
nlohmann::ordered_json comparison_json(const Comparison& comparison, const std::vector<std::string>& others);
nlohmann::ordered_json mean_json(const Mean& mean);

}  // namespace hexrelief::bench::rd
