// The part of the image that the lattice covers.
#pragma once

#include <vector>

#include "mesher/som/level_plan.h"
#include "pipeline/data/density_map.h"

namespace hexrelief::som {

// MeshBorder::fit: the smallest rectangle around all density, grown until it has at least a pixel for each
// vertex and the lattice's spacings in the two directions differ by at most a factor of kMostStretch.
// Otherwise, or where there is no density, the whole image.
MeshArea mesh_area(const DensityMap& density, const MeshConfig& config);

// The upper and the lower border of the lattice as y, in px from the area's upper side, at x = 0, 1, .. width
// of the area. Both empty where the borders are the area's own.
struct MeshOutline {
    std::vector<float> upper, lower;
};

// MeshBorder::fit with balancing: both borders bend towards the density where the area is empty, by at most
// kMostBend of its height, no steeper than kMostOutlineSlope, and leave a margin of two spacings around all
// density. A mesh without these empty parts needs no thin triangles to span them.
MeshOutline mesh_outline(const DensityMap& density, const MeshArea& area, const MeshConfig& config);

// The outline as a level reads it. upper, lower: copies of its curves in the memory of that level's positions
// (host or device).
step::Outline outline_of(const MeshOutline& outline, const float* upper, const float* lower, int level);

// The density within the area, row after row.
std::vector<float> density_within(const DensityMap& density, const MeshArea& area);

}  // namespace hexrelief::som
