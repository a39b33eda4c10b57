// The part of the image that the lattice covers.
#pragma once

#include <vector>

#include "mesher/steps/plan.h"
#include "pipeline/data/density_map.h"

namespace hexrelief {

// MeshBorder::fit: the smallest rectangle around all density, grown to at least a pixel a vertex and to at
// most kMostStretch between the spacings of the two directions; else, or without density, the whole image.
MeshArea mesh_area(const DensityMap& density, const MeshConfig& config);

// The density within the area, row after row.
std::vector<float> density_within(const DensityMap& density, const MeshArea& area);

}  // namespace hexrelief
