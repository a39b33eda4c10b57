// The data that the parts of the surface oracle share. None of them includes a header of mesher/.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipeline/data/disparity_map.h"
#include "pipeline/data/geometry.h"
#include "pipeline/data/hex_mesh.h"
#include "pipeline/data/image.h"
#include "surface_oracle.h"

namespace hexrelief::surface::oracle {

// The side between a pixel and its right neighbour or, if `down`, the one below it.
struct CrackEdge {
    int x = 0, y = 0;
    bool down = false;
};

// pixels.cpp: the disparity map without speckles, and its depth discontinuities.
struct Surfaces {
    int width = 0, height = 0;
    float least_jump_px = 0;       // neighbours that differ by more lie on two surfaces
    std::vector<float> disparity;  // px, 0: no foreground
    std::vector<bool> trusted;     // false: in a speckle or a hole, with a neighbour's disparity
    std::vector<bool> jumps[2];  // discontinuities from a pixel to the one on its right ([0]) and below ([1])

    std::size_t index(int x, int y) const { return static_cast<std::size_t>(y) * width + x; }
    float at(int x, int y) const { return disparity[index(x, y)]; }
    // Returns false for crack edges outside the image.
    bool has(const CrackEdge& c) const {
        return c.x >= 0 && c.y >= 0 && c.x < width && c.y < height && jumps[c.down][index(c.x, c.y)];
    }
    float first(const CrackEdge& c) const { return at(c.x, c.y); }
    float second(const CrackEdge& c) const { return c.down ? at(c.x, c.y + 1) : at(c.x + 1, c.y); }
    Vec2f middle(const CrackEdge& c) const {
        const float x = static_cast<float>(c.x), y = static_cast<float>(c.y);
        return c.down ? Vec2f{x + 0.5f, y + 1.0f} : Vec2f{x + 1.0f, y + 0.5f};
    }
};
Surfaces find_surfaces(const DisparityMap& map, float background_px, double cell_px, const Config& config);
// Returns them row by row, those to the right before those down.
std::vector<CrackEdge> all_discontinuities(const Surfaces& s);

// silhouettes.cpp: crossings of straight paths with silhouettes, as a share of the way from a to b; -1: none.
struct SilhouetteLine {
    float x, y, nx, ny;  // a point of the line, and its unit normal towards the nearer surface
};
// Returns them in the order in which the path from a to b steps over them.
std::vector<CrackEdge> discontinuities_between(const Surfaces& s, const Vec2f& a, const Vec2f& b);
SilhouetteLine silhouette_line(const Surfaces& s, const CrackEdge& c);
float edge_crossing(const Surfaces& s, const Vec2f& a, bool a_on, const Vec2f& b, bool b_on, bool forth);
float crossing_near_middle(const Surfaces& s, const Vec2f& a, const Vec2f& b);
Vec2f nearest_silhouette_point(const Surfaces& s, const Vec2f& p, const Vec2f& crossing);
// Returns a coordinate moved by by_px px.
float moved(float place, double by_px);
Vec2f between(const Vec2f& a, const Vec2f& b, float share);

// lattice.cpp: triangles in the image plane.
struct PlaneMesh {
    std::vector<Vec2f> points;
    std::vector<Triangle> triangles;
};
// Moves lattice vertices onto silhouettes; returns true for those that lie on one.
std::vector<bool> snap_vertices(const Surfaces& s, HexMesh2D& lattice);
PlaneMesh triangles_of(const HexMesh2D& lattice);
// Returns the triangle across each edge, from corner k to k + 1; -1: none.
std::vector<std::array<int, 3>> neighbours_of(const std::vector<Triangle>& triangles);
// split.cpp
void split_at_silhouettes(const Surfaces& s, const std::vector<bool>& on_silhouette, PlaneMesh& mesh);
void split_straddling(const Surfaces& s, const std::vector<bool>& straddling, PlaneMesh& mesh);

// labels.cpp: the surface that each triangle lies on.
struct Labels {
    std::vector<int> triangle;        // per pixel: the triangle that contains its centre, -1: none
    std::vector<bool> in_label;       // per pixel: true if it is in that triangle's largest component
    std::vector<std::size_t> anchor;  // per triangle: the first pixel of that component
    std::vector<bool> kept;           // per triangle: true if it lies on the foreground
    std::vector<bool> straddling;     // per triangle: true if its other components cost much
    std::vector<bool> plain;          // per triangle: true if it is certainly on one surface, see step 8
};
Labels label_triangles(const Surfaces& s, const PlaneMesh& mesh, double cell_px);

// edges.cpp: for each triangle, the edges from corner k to k + 1 along which the mesh is cut.
using CutEdges = std::vector<std::array<bool, 3>>;
CutEdges vote_on_edges(const Surfaces& s, const PlaneMesh& mesh, const Labels& labels);
void join_cuts(const PlaneMesh& mesh, const Labels& labels, CutEdges& cut);

struct CutMesh {
    std::vector<Vec2f> points;
    std::vector<Triangle> triangles;
    std::vector<std::uint32_t> source_triangles;
};
// Gives each vertex fan a vertex of its own.
CutMesh cut_vertices(const PlaneMesh& mesh, const std::vector<bool>& kept, const CutEdges& cut);

// silhouette_fit.cpp, inset.cpp: positions of silhouette vertices.
//
// Returns the corners of a triangle that may move, in any subset, without making it thinner than `least`
// or than it is.
std::array<bool, 3> free_corners(const std::array<Vec2f, 3>& from, const std::array<Vec2f, 3>& to,
                                 double least);
void fit_silhouettes(const Surfaces& s, const std::vector<bool>& kept, const CutEdges& cut, PlaneMesh& mesh);
void inset_silhouettes(const Surfaces& s, const DisparityMap& map, double by_px, const PlaneMesh& uncut,
                       const std::vector<bool>& kept, const CutEdges& cut, CutMesh& mesh);

// disparity_fit.cpp
std::vector<float> fit_disparities(const Surfaces& s, const Labels& labels, const CutMesh& mesh);

}  // namespace hexrelief::surface::oracle
