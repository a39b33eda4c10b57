// The triangle mesh in space that the exporters write.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipeline/data/geometry.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief {

// The view that a part of a mesh is made of: the left or the right camera's, or that of a place where no
// camera was.
enum class PartOrigin : std::uint8_t { left, right, nobody };
struct MeshPart {
    PartOrigin origin = PartOrigin::left;
    std::size_t vertices = 0, triangles = 0;  // how many
};

// The cameras that saw a vertex; left is also what is told of a mesh of one view. filled, where that is asked
// for: the left one saw it, and no match or measurement supports its depth. Files hold these numbers.
enum class Provenance : std::uint8_t { both, left, right, nobody, filled };
inline constexpr std::array<const char*, 5> kProvenanceNames = {"both", "left", "right", "nobody", "filled"};

// Coordinates are glTF's: camera at the origin, +X right, +Y up, looking along -Z; metres, or relative units
// if the calibration is not metric. Triangles are counter-clockwise seen from the camera. All per-vertex
// arrays have the same length, unless they may be empty.
struct SurfaceMesh {
    std::vector<Vec3f> positions;
    std::vector<Vec3f> normals;  // unit length, towards the camera
    // (0, 0) = top left corner of the texture, (1, 1) = bottom right; half a pixel at most from the vertex's
    // place in its picture.
    std::vector<Vec2f> texcoords;
    std::vector<Vec2f> image_points;     // px in the left image
    std::vector<float> disparities;      // px
    std::vector<Provenance> provenance;  // empty = the left camera saw all of it
    std::vector<Triangle> triangles;
    // In the order of the vertices and of the triangles, the left view's first; empty = all are the left
    // view's.
    std::vector<MeshPart> parts;
    bool metric = false;

    bool empty() const { return triangles.empty(); }
    std::size_t left_vertices() const { return parts.empty() ? positions.size() : parts[0].vertices; }
    std::size_t left_triangles() const { return parts.empty() ? triangles.size() : parts[0].triangles; }
    std::size_t triangles_of(PartOrigin origin) const {
        if (parts.empty()) return origin == PartOrigin::left ? triangles.size() : 0;
        std::size_t count = 0;
        for (const MeshPart& part : parts) count += part.origin == origin ? part.triangles : 0;
        return count;
    }
};

}  // namespace hexrelief
