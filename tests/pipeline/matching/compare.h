// Between the oracle's values and those of pipeline/matching.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <string>

#include "oracle.h"
#include "pipeline/matching/matcher.h"
#include "pipeline/matching/sgm/paths.h"

namespace hexrelief::oracle {

template <typename T>
Grid grid_of(const Raster<T>& raster) {
    Grid grid(raster.width(), raster.height(), 0);
    for (int y = 0; y < grid.height; ++y)
        for (int x = 0; x < grid.width; ++x) grid.at(x, y) = static_cast<int>(raster.view().at(x, y));
    return grid;
}
// Outside of the grid: `outside`.
template <typename T>
Raster<T> raster_of(const Grid& grid, T outside) {
    Raster<T> raster(grid.width, grid.height, outside);
    for (int y = 0; y < grid.height; ++y)
        for (int x = 0; x < grid.width; ++x) raster.view().at(x, y) = static_cast<T>(grid.at(x, y));
    return raster;
}
inline Disparities16 map_of(const Grid& grid) {
    return raster_of<std::int16_t>(grid, kUnknown16);
}
inline Grid grid_of(const MatchedMap& map) {
    return Grid(map.width, map.height, {map.disparities.begin(), map.disparities.end()});
}
inline Grid matched_of(const MatchedMap& map) {
    return Grid(map.width, map.height, {map.is_matched.begin(), map.is_matched.end()});
}

inline MatchingConfig config_of(const Settings& settings) {
    return {{settings.min_px, settings.count},
            {settings.p1, settings.p2},
            {settings.min_px, settings.limit, settings.speckle_pixels, settings.speckle_step}};
}

// Scenes that a test looks at; the environment variable HEXRELIEF_ORACLE_SCENES asks for more of them.
inline int scene_count() {
    const char* asked = std::getenv("HEXRELIEF_ORACLE_SCENES");
    return asked ? std::max(1, std::atoi(asked)) : 40;
}

// Empty where they agree, else the first difference.
inline std::string difference(const Grid& oracle, const Grid& matcher) {
    if (oracle.width != matcher.width || oracle.height != matcher.height) return "another size";
    for (int y = 0; y < oracle.height; ++y)
        for (int x = 0; x < oracle.width; ++x)
            if (oracle.at(x, y) != matcher.at(x, y))
                return "(" + std::to_string(x) + ", " + std::to_string(y) + "): the oracle says " +
                       std::to_string(oracle.at(x, y)) + ", the matcher " + std::to_string(matcher.at(x, y));
    return {};
}

// The volume of a picture's rows whose vertical paths begin at its first and last row.
inline void aggregate_alone(const MatchingInput& input, MatchingVolume& volume, ThreadPool& pool) {
    PathRows ends(2, volume.width, volume.count);
    ends.begin(0);
    ends.begin(1);
    aggregate(input, ends.row(0), ends.row(1), volume, pool);
}

}  // namespace hexrelief::oracle
