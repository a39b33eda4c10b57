// What another camera sees and the surface so far does not show.
#pragma once

#include <algorithm>
#include <vector>

#include "pipeline/data/disparity_map.h"
#include "pipeline/data/surface_mesh.h"
#include "pipeline/stages/other_views/view_place.h"

namespace hexrelief::stages {

// A view with the part of it that is missing in a surface. All members but the picture have the view's size.
struct OtherView {
    ViewPlace place;
    DisparityMap map;           // of the whole view, for find_missing(); empty = by map_by_surface()
    DisparityMap missing = {};  // the same at the pixels that the surface leaves open or hides; all others
                                // are unknown
    Image color = {};           // of the whole view; empty = none
    Image picture = {};  // the same at another size, a backing's with its texture; empty = `color` is it
    std::vector<std::uint8_t> kept = {};  // 1 = the picture shows the pixel; empty = all
    bool is_backing = false;              // it is behind what continues, too
    const Image& texture() const { return picture.empty() ? color : picture; }
};

// Returns the pair seen in a mirror, which makes the right camera the left one: a matcher finds the right
// view's disparities, mirrored.
StereoPair mirrored(const StereoPair& pair);
// Returns the map mirrored.
DisparityMap mirrored(DisparityMap map);

// Sets `missing` of the right camera's view, which has its map, to what the surface leaves open there. A
// disparity that would put a pixel in front of what the left camera sees is wrong: the pixel gets the farther
// of the surfaces beside it in its row. only_joined: so do pixels that continue neither of these within
// steps of 2 px. here, in_left: the left view's surface as the right and as the left camera see it.
void find_missing(OtherView& right, const SeenSurface& here, const SeenSurface& in_left, bool only_joined,
                  int threads);

// What a view shows of a surface, from the first to the end of the last pixel of each row and column. The
// first of a row or column without any is not before its end.
struct Frame {
    struct Line {
        double first = 0, end = 0;
        // Of the line that cameras beside the view see, from the first to the end as well: what lies behind
        // comes out there.
        double first_seen = 0, end_seen = 0;
        bool is_empty() const { return first >= end; }
        double nearest(double at) const { return std::clamp(at, first, end); }
    };
    std::vector<Line> rows, columns;
    double baselines;  // of these cameras beside the view, on both sides of a row or column
};
// What the cameras see of a line is at least as long as that of lines on both of its sides, within a tenth of
// the view.
Frame frame_of(const SeenSurface& seen, double baselines);
// Drops from `missing` what lies beyond the frame in its row of the left view.
void keep_in_frame(OtherView& view, const Frame& left_frame);
// Moves the vertices of a cut mesh of a view that lie beyond the left view's frame to its border, along their
// row or column of the left view. Brings what the frame's cameras would see beyond its lines forward to the
// border, within a tenth of the left view from there, but not in front of what `left` shows up to `radius` px
// of the left view around. Drops triangles that this leaves without area.
void move_into_frame(DisparityMesh& cut_mesh, const ViewPlace& place, const Frame& left_frame,
                     const SeenSurface& left, int radius);

// Returns the provenance of each vertex of a surface with all its parts. The left view's part was seen by the
// left camera. A camera saw a vertex if in its view the surface at the vertex's pixel, or at one beside it,
// is at most 1 px of disparity in front of the vertex. seen: by the left camera and, if there was one, by the
// right camera; parts that no camera saw may be left out there. The same for any number of threads.
std::vector<Provenance> provenance_of(const SurfaceMesh& mesh, const std::vector<SeenSurface>& seen,
                                      int threads);

}  // namespace hexrelief::stages
