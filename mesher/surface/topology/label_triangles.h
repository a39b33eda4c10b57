// The parts that the lattice's mesh is opened with: triangles split along silhouettes, each on one side, fans
// of triangles that hang together.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/common/block_allocator.h"
#include "mesher/common/thread_pool.h"
#include "mesher/common/uninitialized_vector.h"
#include "mesher/surface/pixels/discontinuities.h"
#include "mesher/surface/topology/edge_votes_step.h"
#include "mesher/surface/topology/rasterize_step.h"
#include "mesher/surface/topology/triangle_components.h"
#include "pipeline/data/disparity_mesh.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief {

struct SplitLattice {
    std::vector<Vec2f> points;      // the lattice's, then those put on edges
    RawVector<Triangle> triangles;  // positive area, inverted and degenerate ones left out
    RawVector<std::array<std::int32_t, 3>> neighbours;  // across the edge from corner k to k + 1; -1: none
    enum Change : std::uint8_t { kSame, kMoved, kNew };
    std::vector<std::uint8_t> changed;  // a triangle: how, since TriangleLabeler last saw it
};

// Splits the triangles whose edges still cross a silhouette there.
SplitLattice split_at_silhouettes(const PixelSurfaces& surfaces, const HexMesh2D& mesh,
                                  const std::vector<std::uint8_t>& on_silhouette, ThreadPool& pool);

struct TriangleLabels {
    RawVector<std::uint8_t> kept;      // a triangle: whether it lies on the foreground
    RawVector<std::uint32_t> anchors;  // a triangle: a pixel of its surface
    // A triangle: the pixels that its surface is fitted to, row by row, some of them empty; they are the
    // TriangleLabeler's.
    RawVector<std::span<const PixelRun>> fitted;
    RawVector<std::uint8_t> straddling;  // a triangle: whether a good part of its pixels lies elsewhere
    // A triangle's edges to higher ones: whether the surfaces differ there.
    RawVector<std::array<std::uint8_t, 3>> open;
};

// Each triangle lies on the surface that most of its pixels belong to; the edge between two triangles is open
// where most pairs of pixels along it lie on different surfaces.
class TriangleLabeler {
  public:
    // cell_px: area of a lattice cell.
    TriangleLabeler(const PixelSurfaces& surfaces, double cell_px, ThreadPool& pool);
    // Looks at the triangles that have changed, and takes their marks away. Their edges are left as they
    // were.
    void update(SplitLattice& lattice);
    // Looks at the edges of the triangles that have changed since it last did.
    void open_edges(const SplitLattice& lattice);
    // After the last open_edges(): opens the closed edges between the ends of two cuts, and one more at a
    // cut's end where the triangles' own pixels still lie on different surfaces.
    void join_cuts(const SplitLattice& lattice);
    // Fills in `fitted` from the last update.
    void collect_pixels(const SplitLattice& lattice);
    const TriangleLabels& sides() const { return sides_; }

  private:
    struct Rows {
        PixelRun* runs = nullptr;
        std::uint32_t count = 0, room = 0;
    };
    // Pixels first .. end - 1 of a row, and what they say of whose they are.
    struct Part {
        std::uint32_t first, end, place;
    };
    // What one thread finds anew.
    struct Renewal {
        explicit Renewal(const step::PixelView& view) : pieces(view) {}
        Blocks<PixelRun> runs;                 // of all of them, those of before as well
        std::vector<std::uint32_t> triangles;  // that have other pixels than before
        std::vector<Part> parts;               // of those with discontinuities
        TriangleComponents pieces;
        std::vector<PixelRun> room;       // for the pixels of one
        std::vector<std::uint32_t> lost;  // triangles with pixels that a lower one took at the same time
    };
    std::span<const PixelRun> rows(std::uint32_t t) const { return {rows_[t].runs, rows_[t].count}; }
    bool find_pixels(const SplitLattice& lattice, std::uint32_t t, Renewal& renewal);
    void look_at(const SplitLattice& lattice, std::uint32_t t, Renewal& renewal);
    void look_at_pixels(std::uint32_t t);
    bool is_linked(const PixelRun& upper, const PixelRun& lower) const;
    void claim_pixels(std::uint32_t t, const std::vector<Part>& parts, std::size_t& next);
    bool is_plain(std::uint32_t t) const { return plain_[t] && areas_[t] > 0; }
    bool is_quiet(const SplitLattice& lattice, std::uint32_t t) const;
    void vote(const SplitLattice& lattice, std::uint32_t t);
    step::EdgeVotes count_votes(const SplitLattice& lattice, std::uint32_t t) const;
    bool differ(std::uint32_t a, std::uint32_t b) const;
    void claim(std::size_t first, std::size_t end, std::uint32_t place);
    bool has_lost(std::uint32_t t) const;
    double outlier_error(const TriangleComponents& pieces, const TriangleComponents::Largest& largest) const;
    std::span<const PixelRun> fitted_rows(std::uint32_t t, Renewal& renewal);

    step::PixelView view_;
    float discontinuity_px_;
    double cell_px_, nearest_px_ = 0;
    ThreadPool& pool_;
    TriangleLabels sides_;
    RawVector<std::uint32_t> places_;        // a pixel: step::place_of() its triangle
    RawVector<Rows> rows_;                   // a triangle: its pixels
    std::vector<Renewal> renewals_;          // of each thread, during an update
    RawVector<std::uint8_t> renewed_;        // a triangle: whether its edges are still to be looked at
    RawVector<std::uint32_t> side_, areas_;  // a triangle: first pixel of its side; its pixels
    // a triangle: no discontinuity at any of its pixels; none that parts them; no speckle in it
    RawVector<std::uint8_t> plain_, whole_, trusted_;
};

// Splits the edges of straddling triangles where they cross a silhouette. Triangles that stay whole keep
// their numbers.
void split_straddling(const PixelSurfaces& surfaces, const TriangleLabels& sides, SplitLattice& lattice,
                      ThreadPool& pool);

// Gives each fan of kept triangles, which hang together through closed edges at a vertex, a vertex of its
// own. Returns for each new vertex the old one, ascending; triangles become those kept, `origins` their old
// numbers.
std::vector<std::uint32_t> split_non_manifold_vertices(const SplitLattice& lattice,
                                                       const TriangleLabels& sides,
                                                       std::vector<Triangle>& triangles,
                                                       std::vector<std::uint32_t>& source_triangles,
                                                       ThreadPool& pool);

// What split_non_manifold_vertices() was given, and what it gave.
struct SplitVertices {
    const SplitLattice& lattice;
    const TriangleLabels& sides;
    const std::vector<std::uint32_t>& source_vertices;
    const std::vector<Triangle>& triangles;
    const std::vector<std::uint32_t>& source_triangles;
};

// Moves the copies of a vertex at a high depth discontinuity apart, by `by_px` each, into their own surfaces,
// unless that uncovered a pixel away from high steps; at a step down to the background there is but one.
void inset_silhouettes(const PixelSurfaces& surfaces, const DisparityMap& map, double by_px,
                       const SplitVertices& fans, std::vector<Vec2f>& points, ThreadPool& pool);

// Disparities of the vertices of `triangles`, fitted to the triangles' own pixels; `origins` are the
// triangles' numbers in sides.
std::vector<float> fit_disparities(const PixelSurfaces& surfaces, const std::vector<Vec2f>& points,
                                   const std::vector<Triangle>& triangles, const TriangleLabels& sides,
                                   const std::vector<std::uint32_t>& source_triangles, ThreadPool& pool);

// Takes the slivers away (steps/sliver.h), and the vertices that nothing then uses; those of slivers may be
// non-manifold. Before, every vertex holds one fan.
void remove_slivers(DisparityMesh& cut_mesh, double discontinuity_px, ThreadPool& pool);

}  // namespace hexrelief
