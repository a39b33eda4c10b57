// Figures that distinguish a disparity map from a picture of something else.
#pragma once

#include "pipeline/data/disparity_map.h"

namespace hexrelief::checks {

// Figures of known pixels sampled all over the map.
struct MapValues {
    int count = 0;
    double median_px = 0;
    double largest_px = 0;  // except for one in a hundred
    bool are_bytes = true;  // all are integers up to 255
    // Rank correlation of value and row; above 0 if values grow downwards, as they do on the ground.
    double row_correlation = 0;
};

MapValues measure_values(const DisparityMap& map);

// The conversion to px: stored sample / scale + offset_px.
struct MapScale {
    double scale = 1, offset_px = 0;
};

// True if all samples were integers up to 255, as a picture's grey levels are and hardly any map of floats.
bool are_greys(const DisparityMap& map, const MapScale& stored);

// Returns whether slanted planes are straight in the values or in their reciprocals: a plane's disparities
// are linear in the picture, its depths are not, but their reciprocals are. -1 if all are straighter as
// reciprocals, 1 if all are straighter as they are, 0 if few are found. Runs of a quarter of the width are
// compared, since the bend of a plane grows with the square of its length, and noise does not.
double measure_straightness(const DisparityMap& map);

// The places where values rise and fall again on smooth ground. On a surface they have any value. In the grey
// of a colour-mapped picture, slopes turn all over the picture at the largest grey, because the colour map
// itself rises and falls.
struct TurningPoints {
    int count = 0;
    double topmost_share = 0;  // share of them within 3 % of the map's largest value
    // Length of the first 3 % below the top, divided by that of the first 12 %, on slopes that go down that
    // far: 1/4 for a fold, 1/2 for a round top, 0 if there is no such slope.
    double roundness = 0;
};

TurningPoints measure_turning(const DisparityMap& map);

}  // namespace hexrelief::checks
