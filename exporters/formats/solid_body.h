// A body for printing, made of a surface.
#pragma once

#include "pipeline/data/surface_mesh.h"

namespace hexrelief::exporters {

// Closes the left view of a surface: each of its points casts a body away from the camera, along its ray, to
// a flat base behind the farthest of them. So no wall overhangs when the base lies down, and from the camera
// the body looks like the surface. The base is size_mm wide or high, whichever is more, and lies on z = 0, +Z
// up, mm; the body is at least kLeastThickness_mm thick. The farthest thousandth of the vertices moves to the
// depth of the others. Every edge belongs to two triangles if the surface has no edge of more than two; the
// pieces of a surface in pieces are closed each by itself. Positions only. Precondition: all depths are above
// 0.
SurfaceMesh solid_body(const SurfaceMesh& surface, double size_mm);

inline constexpr double kLeastThickness_mm = 2;  // of a base of 40 mm and more, a twentieth of smaller ones

}  // namespace hexrelief::exporters
