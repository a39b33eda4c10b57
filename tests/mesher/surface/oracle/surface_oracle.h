// The result that the surface stage must give for a lattice and a disparity map, by a slow and plain program
// that shares no code with mesher/: it recomputes everything that the mesher updates, skips or sums in closed
// form. The recipe follows; each step is a function of its own.
//
// WORDS. Pixel (x, y) is the unit square with its centre at +0.5. A crack edge is the side between a pixel
// and its right neighbour, or the one below it. A discontinuity is a crack edge between two surfaces;
// silhouettes are the lines that discontinuities form. A lattice cell has as many px2 as the map has pixels
// per lattice vertex. "Row by row" means from left to right within a row, and at a pixel the crack edge on
// its right before the one below it. A share is a part of the way from an edge's first end to its second.
//
// ROUNDING. Triangles and their order depend on the last bit, so the precision is part of the recipe. Floats,
// each sum in the order that is given: steps 1 to 7, 9, GEOMETRY, and the demands of single crack edges in
// 11. Doubles: areas, which pixels lie in a triangle, costs in 8, sums and vertices' equations in 11, shapes
// in 11 and 14, directions inwards in 14, all of 15. A point that moves along a line, an edge or a normal
// moves by a whole number of 1/1024 px across and down, halves away from 0. The pixel at some distance from a
// point is found from that point's pixel, and the planes of 15 from the pixel of the vertex.
//
// PIXELS
//  1. Foreground. Disparities that are not finite, not above 0, or below background_px become 0.
//  2. The least jump is least_discontinuity_px. If that is 0, it is 1 + 1/64 px.
//  3. Pixels between two steps, not in `bridge`. Of five pixels p q r s t in a row, r takes the disparity of
//     s if s is foreground, q - r > least jump, r - s > least jump and r - s < 4 px; but not if that is a
//     part of a longer slope: p - q > least jump, or t is foreground and s - t > least jump. Outside the
//     image are zeros. All pixels change at once.
//  4. Holes are 4-connected regions of zeros. Those smaller than a cell are absorbed. Ring by ring, from its
//     border inwards, each pixel of such a hole takes the least disparity of its 4-neighbours outside it or
//     in earlier rings. None of these pixels is trusted from then on.
//  5. Discontinuities. Between two pixels a and b (b on the right of a or below it) there is a step if only
//     one of them is foreground or, but not in `bridge`, if they differ by more than the least jump. A step
//     is a discontinuity, unless both pixels are foreground and it is only a part of something:
//     - Not the steepest part: the step is at most 2.3 px high, and the step to a from the pixel before it,
//       which is foreground, goes the same way and is at least as high; or the step from b to the next
//       foreground pixel goes the same way and is higher.
//     - Part of a slope down a column: there is a row above a and one below b; the pixel six rows above a, or
//       fewer at the image's border, is foreground, and so is that below b; and height - 2 max(0, m) <= least
//       jump. The lesser of the mean steps over these rows above and below is m; each step there counts in
//       the direction of the step from a to b, and is clamped to twice its height either way.
//     Speckles are regions connected across crack edges that are not discontinuities, of fewer than 5 pixels.
//     They are absorbed like holes, but take the largest disparity. Then the discontinuities are recomputed.
//
// GEOMETRY
//   Path from a to b: it has n = floor(2 |b - a|) + 1 steps. After k steps it is at the pixel that contains a
//     + (k / n) (b - a), clamped to the image. From one pixel to the next it goes sideways first, then up or
//     down, and meets the discontinuities that it steps over, in this order.
//   Silhouette line of a discontinuity c: sums are taken over the discontinuities right of and below the
//     pixels of the 5 x 5 window around c's pixel, row by row. One is left out if it has c's direction, but
//     its nearer pixel on the other side. Its weight is (1 - (distance from c's midpoint / 2.75)^2)^2, or 0
//     beyond 2.75 px. The normal is the weighted sum of the unit vectors towards the nearer pixels. If it is
//     not longer than 0.1 times the weights' sum, the line goes through c's midpoint along c. Otherwise it
//     goes through the weighted mean of the midpoints (as a point of the line: c's midpoint, moved along the
//     normal).
//   Meeting of an edge and a silhouette line, as a share of the edge: their crossing, or the edge's point
//     nearest to the line's point if the line's normal has a component along the edge of 0.1^0.5 or less.
//     Then clamped to 0 .. 1.
//   Edge crossing of an edge from a to b, of which each end may lie on a silhouette already: there is none if
//     both do. The edge is walked over from its vertex with the lower number to the other. If a is on a
//     silhouette the discontinuity met nearest to b counts, else the one nearest to a. The crossing is the
//     meeting with its line. A crossing with share <= 0.3 does not count if a is on a silhouette, and one
//     with share > 0.7 does not count if b is.
//
// LATTICE
//  6. Vertices move onto silhouettes. A vertex that is not on one has a crossing: the one at the least share
//     on the edges from it to its six neighbours, the first of equal ones (east, then by rising row). The
//     vertices whose crossing is within a share of 0.75 are visited by these shares, equal ones by the hash
//     in lattice.cpp. A visited vertex searches its crossing again, because neighbours may have moved, and
//     stays if that is beyond 0.75. Otherwise it tries to move to the nearest silhouette point and, if that
//     is refused, to the crossing. The former: of the discontinuity whose midpoint is nearest (the first of
//     equal ones, row by row), the foot on its silhouette line, but at most 0.75 px from the line's point.
//     The midpoint must be nearer than the crossing's distance plus 0.5 px, otherwise the crossing takes its
//     place. Vertices on the image's border keep the coordinate that puts them there, its corners stay, all
//     are clamped to the image. A move is refused if the worst shape of the triangles at the vertex would be
//     below 0.3 and less than before. The shape, sqrt(12) times twice the area over the sum of the squared
//     sides, counts as 1 at most.
//  7. Triangles are those of the lattice's quads of which twice the area is above 1e-4. Each edge, its vertex
//     with the lower number first, is split at its crossing if the share is within 0.12 .. 0.88. New vertices
//     are numbered by the lower of the edges' triangles, then by the corner at which the edge begins there.
//     Of a triangle a b c with one split edge, ab, (a ab c) (ab b c) remain. Of one with ab and ca split (a
//     ab ca) remains, and the quad ab b c ca by its shorter diagonal, ab-c of equal ones: (ab b c) (ab c ca),
//     or (ab b ca) (b c ca). Of three: (a ab ca) (b bc ab) (c ca bc) (ab bc ca). Parts whose doubled area is
//     not above 1e-4 are left out. The first of the others takes the triangle's number, the rest follow after
//     all existing triangles. A triangle without a remaining part stays whole.
//
// ROUNDS. Steps 8, 9, 8, 10, 11, split_rounds times. Then 8, 10, and 12 to 15.
//  8. Labels. A triangle has the pixels whose centres lie in it (covers() in labels.cpp assigns a centre on
//     an edge). Two of these are connected if they are neighbours without a discontinuity between them, or if
//     they touch at a corner and one of the two ways around it, over whichever triangle's pixel it leads,
//     meets no discontinuity. If two successive rows do not touch, not even at a corner, their nearest pixels
//     are connected if the path between their centres meets none. The triangle's label is the largest
//     connected component, of equal ones the one with the first pixel. Its anchor is the label's first pixel,
//     or without pixels the one at its centre. It is kept if its anchor is foreground. All other pixels are
//     outliers. A triangle with two or more straddles surfaces if those that are trusted cost more than 0.5
//     px2 times the pixels of a cell. With m the label's mean disparity and D the largest of the map, an
//     outlier of disparity d costs (d / D)^3 min(|d - m|, 10)^2, and 4 times that if d < m; with d = 0 it is
//     (0.7 m / D)^3 10^2, with m = 0 (d / D)^3 10^2.
//  9. The edges of triangles that straddle surfaces are split as in 7. Each edge is walked from its midpoint
//     to either end. Of the meetings with the silhouette lines of the first discontinuities on both ways, it
//     is split at the one nearer to its midpoint, of equally near ones at the one found towards its lower
//     vertex. A triangle is plain if it has pixels, each row of them has a column in common with the row
//     above, and none of them has a discontinuity on its right or below it.
// 10. Edge votes. Each two 4-neighbours in different triangles, both in their labels, vote on the edge
//     between these: for a cut if a discontinuity lies between them, else against it. An edge is cut if more
//     votes are for a cut than against it. An edge without votes is joined if the lower of its triangles and
//     all neighbours of that triangle are plain. Any other edge is cut if its anchors differ: if their
//     disparities differ by more than the least jump, or only one of them is foreground, and the path from
//     the centre of the lower triangle's anchor to the other's meets a discontinuity.
// 11. Silhouette fit. Silhouette edges lie between two triangles of which only one is kept, or both are kept
//     and the edge is cut. Five times, each edge sees discontinuities and asks its two vertices to move; then
//     all move at once.
//     - It sees those whose midpoints project onto it, at a residual r of at most 1.5 px: the distance along
//       the edge's normal (-dy, dx), the edge running as the lower of its triangles has it. Of a
//       discontinuity from a pixel a to b on its right with b > 0, 0 < a - b < 4 px, the midpoint counts as
//       410/1024 px farther left. f is the component of the unit vector towards the nearer pixel along the
//       normal. The weight is 1 - (r / 1.5)^2, twice that if |r| > 0.5 |f| - 0.05.
//     - Only those count whose f has the sign of the sum of all weight times f. Each asks the edge's second
//       vertex to move by r along the normal, with share times weight, and its first vertex with the rest of
//       the weight.
//     - A vertex would move by the least squares of all demands on it, with a weight of 0.3 added for
//       staying, in both coordinates. It stays if that is less than 0.03 px. Vertices on the image's border
//       move along it, none leaves it.
//     - Each triangle asks its moving corners, the farthest first, equal ones in their order. A corner may
//       move if, for every subset of those that may move already, the triangle with the subset and this
//       corner moved has a shape of at least 0.2, or not below its present one. A vertex moves if all its
//       triangles allow it.
//
// AFTER THE ROUNDS
// 12. Cuts are joined. A border edge is one that is cut, or has only one kept triangle. Joined edges between
//     kept triangles are visited by their lower triangle and its corner. Those with exactly one border edge
//     at each end are cut; that makes more border edges at these, which counts for the edges that follow.
// 13. Vertices are split. Corners at a vertex belong to one vertex fan if edges that are not cut join their
//     kept triangles. Each fan has a vertex, numbered by the source vertex, then by the fan's first corner.
//     Kept triangles stay in their order; the others are dropped.
// 14. Inset, if inset_px is above 0. A vertex lies at the discontinuities right of and below its pixel and
//     the eight pixels around it. Such a step has the height of its disparities; if one is not foreground,
//     that of the map's values, and then it counts only if both are above 0 and finite. A vertex would move
//     inwards by inset_px if at least one of these steps counts and all that count are 2.3 px or higher.
//     Inwards is the sum of the normals (-dy, dx) of the edges at the vertex that only one triangle has, each
//     as long as the edge; on the image's border its component across the border is 0. The vertex stays if
//     one of its triangles does not allow the move, as in 11 but with a shape of 0.05; and if a border edge
//     at it, as in 12, would with both ends moved uncover the centre of a pixel (uncovers() in inset.cpp)
//     that is at no discontinuity of 2.3 px or more and at none with a pixel that is not foreground.
// 15. Disparities. A triangle's pixels are now the trusted ones of its label.
//     - Start: a vertex begins on the plane through the pixels of its triangles, at their mean if they hold
//       no plane, and without pixels at the disparity of its first triangle's anchor. n pixels hold a plane
//       if n >= 6, xx + yy > 2 and xx yy - xy^2 > 0.05 (xx + yy)^2, with sums of squared deviations from
//       their mean. No vertex is below the floor, then or later: half of the map's least disparity above 0,
//       and at least 0.001 px.
//     - Fit: weighted least squares of the piecewise linear surface against the triangles' pixels. A pixel
//       has weight 20 if, of the crack edges one and two pixels to its left, the first that is a
//       discontinuity goes down to foreground by less than 4 px; others have weight 1. Each vertex is held at
//       its start by a weight of 0.05. Four Jacobi sweeps, damped by 0.8.
#pragma once

#include <vector>

#include "pipeline/data/disparity_map.h"
#include "pipeline/data/geometry.h"
#include "pipeline/data/hex_mesh.h"
#include "pipeline/data/image.h"

namespace hexrelief::surface::oracle {

struct Config {
    bool bridge = false;                // one surface, cut only at background and unknown pixels
    double least_discontinuity_px = 0;  // 0: 1 + 1/64 px
    int split_rounds = 3;               // >= 1
    double inset_px = 0;                // 0 .. 0.5
};

struct Mesh {
    std::vector<Vec2f> points;       // px
    std::vector<float> disparities;  // px
    std::vector<Triangle> triangles;
};

// Runs the recipe. lattice: without inverted or overlapping triangles; map: not empty.
Mesh cut_disparity_mesh(HexMesh2D lattice, const DisparityMap& map, float background_px,
                        const Config& config);

}  // namespace hexrelief::surface::oracle
