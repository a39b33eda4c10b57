// The paper's Table 2: its maps, their folders in Middlebury's data sets, and its figures.
#pragma once

#include <array>

namespace hexrelief::bench::table2 {

struct PaperMap {
    const char* set;  // the maps that the paper averages over
    const char* name;
    const char* folder;  // in Middlebury's data sets
    double scale;        // raw value / scale = px; raw 0 is unknown
    int ssr;
    double gpu_s, cpu_s, gpu_cost, cpu_cost;  // s and %cost; means of ten runs on hardware of 2012
};

inline constexpr std::array<PaperMap, 18> kPaperMaps{{
    {"first", "tsukuba", "middlebury2001/tsukuba", 16, 3, 0.32, 1.87, 25.89, 25.02},
    {"first", "rocks1", "middlebury2006/rocks1-third", 3, 3, 0.34, 2.28, 17.94, 18.73},
    {"first", "aloe", "middlebury2006/aloe-third", 3, 3, 0.30, 2.50, 27.15, 28.70},
    {"first", "venus", "middlebury2001/venus", 8, 3, 0.32, 2.40, 21.55, 19.62},
    {"first", "teddy", "middlebury2003/teddy-quarter", 4, 3, 0.36, 2.41, 18.45, 20.04},
    {"first", "cones", "middlebury2003/cones-quarter", 4, 3, 0.35, 2.45, 17.24, 16.69},
    {"S", "rocks1S", "middlebury2006/rocks1-third", 3, 4, 0.66, 3.32, 20.03, 18.91},
    {"S", "aloeS", "middlebury2006/aloe-third", 3, 4, 0.51, 3.56, 27.45, 28.02},
    {"S", "conesS", "middlebury2003/cones-quarter", 4, 4, 0.67, 3.52, 18.95, 16.59},
    {"S", "teddyS", "middlebury2003/teddy-quarter", 4, 4, 0.69, 3.45, 18.19, 19.91},
    {"M", "rocks1M", "middlebury2006/rocks1-half", 2, 4, 1.05, 8.33, 21.65, 18.37},
    {"M", "aloeM", "middlebury2006/aloe-half", 2, 4, 0.57, 9.36, 26.39, 26.90},
    {"M", "conesM", "middlebury2003/cones-half", 2, 4, 1.36, 18.52, 18.75, 17.82},
    {"M", "teddyM", "middlebury2003/teddy-half", 2, 4, 1.35, 18.53, 21.07, 19.26},
    {"L", "rocks1L", "middlebury2006/rocks1-full", 1, 4, 2.18, 47.36, 21.73, 19.53},
    {"L", "aloeL", "middlebury2006/aloe-full", 1, 4, 0.95, 53.19, 25.64, 24.72},
    {"L", "conesL", "middlebury2003/cones-full", 1, 4, 2.74, 107.10, 17.27, 25.93},
    {"L", "teddyL", "middlebury2003/teddy-full", 1, 4, 2.13, 110.25, 25.98, 23.63},
}};

}  // namespace hexrelief::bench::table2
