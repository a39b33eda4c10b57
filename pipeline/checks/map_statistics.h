// What tells a disparity map from a picture of something else, in figures.
#pragma once

#include "pipeline/data/disparity_map.h"

namespace hexrelief::checks {

// Of known pixels all over the map.
struct MapValues {
    int count = 0;
    double median_px = 0;
    double largest_px = 0;       // but for one in a hundred
    bool are_bytes = true;       // all of them whole numbers up to 255
    double row_correlation = 0;  // of ranks: above 0 where values grow downwards, as near ground does
};

MapValues measure_values(const DisparityMap& map);

// A stored sample / scale + offset_px are px.
struct MapScale {
    double scale = 1, offset_px = 0;
};

// Whether all samples were whole numbers up to 255, as a picture's grey is and hardly any map of floats.
bool are_greys(const DisparityMap& map, const MapScale& stored);

// A plane's disparities are linear in the picture, its depths are not: their reciprocals are. -1 where all
// slanted planes are straighter as reciprocals, 1 where all are straighter as they are, 0 where none are
// found.
double measure_straightness(const DisparityMap& map);

// Values that rise and fall again on smooth ground. On a surface they turn anywhere; the grey of a colour map
// rises and falls itself: slopes turn all over the picture where they come to the largest grey.
struct TurningPoints {
    int count = 0;
    double topmost_share = 0;  // of them within 3 % of the map's largest value
    // Length of the first 3 % below the top in that of the first 12 %, where slopes go that far: 1/4 of a
    // fold, 1/2 of a round top, 0 where no slope does.
    double roundness = 0;
};

TurningPoints measure_turning(const DisparityMap& map);

}  // namespace hexrelief::checks
