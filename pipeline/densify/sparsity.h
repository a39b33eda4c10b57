// Whether a map holds scattered measurements, as a laser's does, or surfaces with holes.
#pragma once

#include "pipeline/data/disparity_map.h"

namespace hexrelief::densify {

struct Sparsity {
    double known_share = 0;  // of all pixels
    // Share of the known pixels' neighbours along rows, and along columns, that are known as well.
    double joined_along_rows = 0, joined_along_columns = 0;

    // Unknown pixels lie between the known ones: along rows or along columns most known pixels have an
    // unknown neighbour. Where a map has surfaces, nearly all neighbours of a known pixel are known, however
    // large its holes are.
    bool is_sparse() const;
};

Sparsity measure_sparsity(const DisparityMap& map);

}  // namespace hexrelief::densify
