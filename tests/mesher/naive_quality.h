// Quality by definition: every triangle is clipped with every pixel. Slow; it shares nothing with the
// mesher except the data.
#pragma once

#include <vector>

#include "pipeline/data/density_map.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief::testing_mesher {

struct NaiveQuality {
    std::vector<double> weights;  // W_k, ordered by row and column of the centre
    double percent_cost = 0, max_deviation_percent = 0, min_angle_deg = 180;
    std::vector<double> angles_deg;  // the smallest angle of each triangle, in no particular order
    int inverted = 0;
};

NaiveQuality naive_quality(const HexMesh2D& mesh, const DensityMap& density);

}  // namespace hexrelief::testing_mesher
