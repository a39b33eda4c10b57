// The part of the image that the lattice covers, and the curves of its upper and lower border.
#pragma once

#include <vector>

#include "mesher/som/level_plan.h"
#include "pipeline/data/density_map.h"

namespace hexrelief::som {

// For MeshBorder::fit returns the smallest rectangle around all density, grown until it has at least one
// pixel per vertex and the lattice's spacings in the two directions differ by at most the factor
// kMostStretch. For other borders, or if there is no density, returns the whole image.
MeshArea mesh_area(const DensityMap& density, const MeshConfig& config);

// Upper and lower border of the lattice as y in px from the area's upper side, at x = 0, 1, .. width of the
// area. Both are empty if the borders are straight.
struct MeshOutline {
    std::vector<float> upper, lower;
};

// For MeshBorder::fit with balancing, bends both borders towards the density above and below which the area
// is empty: by at most kMostBend of its height, no steeper than kMostOutlineSlope, and with a margin of two
// spacings around all density. A mesh without these empty parts needs no thin triangles to span them.
MeshOutline mesh_outline(const DensityMap& density, const MeshArea& area, const MeshConfig& config);

// Returns the outline scaled for a level. `upper` and `lower` are copies of its curves in the memory of that
// level's positions (host or device).
step::Outline outline_of(const MeshOutline& outline, const float* upper, const float* lower, int level);

// Returns the density within the area, row by row.
std::vector<float> density_within(const DensityMap& density, const MeshArea& area);

}  // namespace hexrelief::som
