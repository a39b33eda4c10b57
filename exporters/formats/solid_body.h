// A body for printing, made of a surface.
#pragma once

#include "exporters/core/scene.h"
#include "pipeline/data/surface_mesh.h"

namespace hexrelief::exporters {

inline constexpr double kLeastThickness_mm = 2;  // of a base of 40 mm and more, a twentieth of smaller ones
inline constexpr double kCrumbShare = 1e-3;      // of the surface's area in the image: smaller pieces go
inline constexpr double kBridgedShare = 0.01;    // of that area: smaller holes are closed

// Closes the left view of a surface: it becomes the lid of a body whose walls run along the camera's rays, to
// a flat base behind the farthest point. So no wall overhangs when the base lies down, and from the camera
// the body looks like the surface. At a silhouette a wall joins the nearer surface to the farther one, if
// both have the same points of the image there, else both to the base; the surface's border has walls to the
// base. Crumbs go, and small holes are bridged, as seen in the image. Every side of a triangle is that of
// exactly one other in the other direction: where walls touch, they have vertices of their own.
//
// The base is size_mm wide or high, whichever is more, and lies on z = 0, +Z up, mm; the body is at least
// kLeastThickness_mm thick. The farthest thousandth of the vertices moves to the depth of the others. The
// front's vertices come before those of the base. Walls and base have the colours of the front: texture
// coordinates are those of the surface, if it has any. A shell has, in place of the base, the farthest front
// on each ray once more, farther by the thickness; the farthest hundredth of its vertices is flat, a foot to
// be printed on. Precondition: all depths are above 0.
SurfaceMesh solid_body(const SurfaceMesh& surface, double size_mm, SolidKind kind = SolidKind::base);

}  // namespace hexrelief::exporters
