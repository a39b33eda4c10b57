// The part of the image that the lattice covers.
#pragma once

#include <vector>

#include "mesher/som/level_plan.h"
#include "pipeline/data/density_map.h"

namespace hexrelief {

// MeshBorder::fit: the smallest rectangle around all density, grown to at least a pixel a vertex and to at
// most kMostStretch between the spacings of the two directions; else, or without density, the whole image.
MeshArea mesh_area(const DensityMap& density, const MeshConfig& config);

// The upper and the lower border of the lattice over the area's columns, at x = 0, 1, .. width, px of the
// area from its upper side. Empty where both are the area's own.
struct MeshOutline {
    std::vector<float> upper, lower;
};

// MeshBorder::fit with a balance: both borders bend towards the density where what lies beyond them is empty,
// by at most kMostBend of the area's height, no steeper than kMostOutlineSlope, and around each spot of
// density they keep two spacings of room. A mesh without these empty parts needs no thin triangles to span
// them.
MeshOutline mesh_outline(const DensityMap& density, const MeshArea& area, const MeshConfig& config);

// The outline as a level reads it; upper, lower: its curves where that level's positions are.
step::Outline outline_of(const MeshOutline& outline, const float* upper, const float* lower, int level);

// The density within the area, row after row.
std::vector<float> density_within(const DensityMap& density, const MeshArea& area);

}  // namespace hexrelief
