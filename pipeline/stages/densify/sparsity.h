// Measures whether a map holds scattered measurements, such as a laser's, or surfaces with holes.
#pragma once

#include "pipeline/data/disparity_map.h"

namespace hexrelief::stages {

struct Sparsity {
    double known_share = 0;  // share of all pixels
    // Share of the known pixels' neighbours along rows, and along columns, that are known as well.
    double joined_along_rows = 0, joined_along_columns = 0;

    // True if unknown pixels lie between the known ones: along rows or along columns most known pixels have
    // an unknown neighbour. In a map of surfaces nearly all neighbours of known pixels are known, however
    // large its holes are.
    bool is_sparse() const;
};

Sparsity measure_sparsity(const DisparityMap& map);

}  // namespace hexrelief::stages
