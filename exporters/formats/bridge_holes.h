// Closes small holes of a triangulation, as seen in the image.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/data/geometry.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief::exporters {

// Adds triangles in the holes that are smaller than `most`, which is twice their area in the image, px^2, and
// have at most kMostHoleSides sides. points[rays[i]] is vertex i in the image; vertices of one ray, which a
// cut has parted, count as joined. At such a ray the hole is closed at the vertex of the highest number. The
// triangles turn as those that are there, all of which turn in the same way. Holes that have no
// triangulation, because their sides cross, stay.
void bridge_holes(std::vector<Triangle>& triangles, const std::vector<std::uint32_t>& rays,
                  const std::vector<Vec2f>& points, double most);

inline constexpr std::size_t kMostHoleSides = 1000;

}  // namespace hexrelief::exporters
