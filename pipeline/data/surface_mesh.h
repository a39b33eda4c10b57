// The triangle mesh in space that the exporters write.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/data/geometry.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief {

// Coordinates are glTF's: camera at the origin, +X right, +Y up, looking along -Z; metres, or relative units
// if the calibration is not metric. Triangles are counter-clockwise seen from the camera. All per-vertex
// arrays have the same length.
struct SurfaceMesh {
    std::vector<Vec3f> positions;
    std::vector<Vec3f> normals;       // unit length, towards the camera
    std::vector<Vec2f> texcoords;     // (0, 0) = top left corner of the left image, (1, 1) = bottom right
    std::vector<Vec2f> image_points;  // px in the left image; texcoords are these divided by the image size
    std::vector<float> disparities;   // px
    std::vector<Triangle> triangles;
    bool metric = false;

    bool empty() const { return triangles.empty(); }
};

}  // namespace hexrelief
