// Converts between the oracle's values and those of pipeline/matching, and compares them.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <string>

#include "matching_oracle.h"
#include "matching_scenes.h"
#include "pipeline/matching/matcher.h"
#include "pipeline/matching/sgm/paths.h"
#include "pipeline/matching/sgm/volume.h"

namespace hexrelief::matching::oracle {

template <typename T>
Grid grid_of(const Raster<T>& raster) {
    Grid grid(raster.width(), raster.height(), 0);
    for (int y = 0; y < grid.height; ++y)
        for (int x = 0; x < grid.width; ++x) grid.at(x, y) = static_cast<int>(raster.view().at(x, y));
    return grid;
}
// Converts a grid; the border gets the value `outside`.
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
    return {
        {settings.min_px, settings.count},
        {settings.p1, settings.p2},
        {settings.min_px, settings.limit, settings.speckle_pixels, settings.speckle_step, settings.least}};
}

// Returns the number of scenes that a test uses; the environment variable
// HEXRELIEF_ORACLE_SCENES sets another one.
inline int scene_count() {
    const char* asked = std::getenv("HEXRELIEF_ORACLE_SCENES");
    return asked ? std::max(1, std::atoi(asked)) : 40;
}

// Returns the first difference; empty if the grids are equal.
inline std::string difference(const Grid& oracle, const Grid& matcher) {
    if (oracle.width != matcher.width || oracle.height != matcher.height) return "another size";
    for (int y = 0; y < oracle.height; ++y)
        for (int x = 0; x < oracle.width; ++x)
            if (oracle.at(x, y) != matcher.at(x, y))
                return "(" + std::to_string(x) + ", " + std::to_string(y) + "): the oracle says " +
                       std::to_string(oracle.at(x, y)) + ", the matcher " + std::to_string(matcher.at(x, y));
    return {};
}

inline SearchWindows windows_of(const Runs& runs) {
    SearchWindows windows(runs.far.width, runs.far.height, kWholeWindow);
    for (int y = 0; y < windows.height(); ++y)
        for (int x = 0; x < windows.width(); ++x)
            windows.view().at(x, y) = {static_cast<std::int16_t>(runs.far.at(x, y)),
                                       static_cast<std::int16_t>(runs.near.at(x, y))};
    return windows;
}
inline Runs runs_of(const SearchWindows& windows, int length) {
    Runs runs{Grid(windows.width(), windows.height(), 0), Grid(windows.width(), windows.height(), 0), length};
    for (int y = 0; y < windows.height(); ++y)
        for (int x = 0; x < windows.width(); ++x) {
            runs.far.at(x, y) = windows.view().at(x, y).far_run;
            runs.near.at(x, y) = windows.view().at(x, y).near_run;
        }
    return runs;
}
// Returns the searched entries, pixel by pixel, in the order of a MatchingVolume. The volume may begin below
// the runs' first row.
inline std::vector<int> entries_of(const Volume& volume, const Runs& runs, int first_row = 0) {
    std::vector<int> entries;
    for (int y = 0; y < volume.height; ++y)
        for (int x = 0; x < volume.width; ++x)
            for (const Grid* run : {&runs.far, &runs.near})
                for (int i = 0; i < runs.length; ++i)
                    entries.push_back(volume.at(x, y, run->at(x, first_row + y) + i));
    return entries;
}

// Returns random winners at half size, known everywhere.
inline Grid any_half_winners(const Scene& scene, int number) {
    Random random(3000 + number);
    const int most = 16 * (half_settings(scene.settings).count - 1);
    Grid half = make_map((scene.pair.left.width + 1) / 2, (scene.pair.left.height + 1) / 2, most, random);
    for (int& disparity : half.values)
        if (disparity == kUnknown) disparity = random.whole(most + 1);
    return half;
}

// Aggregates a volume of a picture's rows as if vertical paths began at its first and last row.
inline void aggregate_alone(const MatchingInput& input, MatchingVolume& volume, ThreadPool& pool) {
    PathRows ends(2, static_cast<std::size_t>(volume.width) * volume.searched);
    ends.begin(0, volume.first_row, input.penalties);
    ends.begin(1, volume.first_row + volume.rows - 1, input.penalties);
    aggregate(input, ends.row(0), ends.row(1), volume, pool);
}

}  // namespace hexrelief::matching::oracle
