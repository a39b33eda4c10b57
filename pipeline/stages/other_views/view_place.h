// Cameras beside the left one, and surfaces as they see them.
#pragma once

#include <vector>

#include "pipeline/data/calibration.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/disparity_mesh.h"
#include "pipeline/data/surface_mesh.h"
#include "pipeline/stages/surface_raster.h"

namespace hexrelief::stages {

// Neighbours of one surface differ by at most this (SurfaceConfig::least_discontinuity_px).
inline constexpr double kOneSurface_px = 1;

// A camera that looks the same way as the left one.
struct ViewPlace {
    double right = 0, up = 0;   // of the left camera, in baselines
    double shift_px = 0;        // what has this disparity lies at the same place in both views
    double scale = 1;           // px of the left view along a side of this view's px
    int width = 0, height = 0;  // of this view, px

    // Converts points (x, y, d) of the left view into points of this one, and back.
    ViewPoint from_left(const ViewPoint& point) const;
    ViewPoint to_left(const ViewPoint& point) const;
};

// Returns the camera there. left: the left camera, with the doffs of the disparities in use.
Calibration camera_at(const ViewPlace& place, const Calibration& left);

// What a surface shows in a view: per pixel, row-major, its disparity in this view's px or kNotCovered.
struct SeenSurface {
    ViewPlace place;
    Disparities disparities;

    // Returns the largest disparity, in px of the left view, at which the left view's point is not in front
    // of the surface here; +infinity if the view does not show the surface there.
    double limit_at(const ViewPoint& left_point) const;
    // Returns the least of these in the pixels around it up to `radius` px away. Gaps of the surface that
    // are not larger do not count.
    double limit_around(const ViewPoint& left_point, int radius) const;
};
// Of `mesh`, the image points, disparities and triangles are used. The same for any number of threads.
SeenSurface see(const SurfaceMesh& mesh, const ViewPlace& place, int threads);

// A surface as cameras see it. Nothing that is added may be in front of it.
struct VisibleSurface {
    std::vector<SeenSurface> seen;  // by each camera
    double least_px;                // px of the left view: nothing that is added is farther
};
VisibleSurface visible_surface(const SurfaceMesh& mesh, const std::vector<ViewPlace>& cameras,
                               double least_px, int threads);
// Adds another part of the surface to what the cameras see. Its least_px stays.
void cover(VisibleSurface& surface, const SurfaceMesh& added, int threads);

// Returns the disparity, in px of this view, of a point moved away from its camera until it is behind the
// surface for all cameras. Unknown if it would be farther than anything.
float behind(ViewPoint point, const ViewPlace& place, const VisibleSurface& surface);

// Moves the vertices of a cut mesh of this view so, and those of triangles that are in front of the surface
// by at most 1 px; splits the other triangles in front of it, and drops their parts that still are, those
// that are too far, those that step by more than most_step_px of the left view beyond a steep slope, and
// pieces of less than a two-thousandth of this view, unless a camera sees 3 square pixels of it and nothing
// else there.
void keep_behind(DisparityMesh& cut_mesh, const ViewPlace& place, const VisibleSurface& surface,
                 double most_step_px, int threads);

// Returns a surface of this view in the left camera's space. Its image points and disparities are the left
// view's; its texture coordinates stay this view's.
SurfaceMesh in_left_space(SurfaceMesh mesh, const ViewPlace& place, const Calibration& left);

// Appends the vertices and triangles of another surface as a part of its own.
void append(SurfaceMesh& mesh, const SurfaceMesh& other, PartOrigin origin);

}  // namespace hexrelief::stages
