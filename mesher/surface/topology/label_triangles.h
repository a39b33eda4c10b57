// Which surface each triangle of the split lattice lies on, and across which edges the surfaces differ.
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
#include "mesher/surface/topology/split_triangles.h"
#include "mesher/surface/topology/triangle_components.h"

namespace hexrelief::surface {

struct TriangleLabels {
    RawVector<std::uint8_t> kept;      // a triangle: whether it lies on the foreground
    RawVector<std::uint32_t> anchors;  // a triangle: a pixel of its label, or its middle's
    // A triangle: the pixels that its surface is fitted to, row by row, some rows empty; TriangleLabeler owns
    // them.
    RawVector<std::span<const PixelRun>> fitted;
    RawVector<std::uint8_t> straddling;  // a triangle: whether its outliers cost too much
    // A triangle's edges: whether the surfaces differ there. The lower triangle of an edge says it.
    RawVector<std::array<std::uint8_t, 3>> open;
};

// Each triangle lies on the surface that most of its pixels belong to; the edge between two triangles is open
// where most pairs of pixels along it lie on different surfaces.
class TriangleLabeler {
  public:
    // cell_px: area of a lattice cell; nearest_px: a disparity that counts as one of the map's.
    TriangleLabeler(const PixelSurfaces& surfaces, double cell_px, float nearest_px, ThreadPool& pool);
    // Labels the triangles that have changed, and clears `changed`. Their edges are left as they were.
    void update(SplitLattice& lattice);
    // Votes on the edges of the triangles that have changed since the last call, and of their neighbours.
    void open_edges(const SplitLattice& lattice);
    // After the last open_edges(): opens the closed edges between the ends of two cuts.
    void join_cuts(const SplitLattice& lattice);
    // Fills in `fitted` from the last update.
    void collect_pixels(const SplitLattice& lattice);
    const TriangleLabels& labels() const { return labels_; }

  private:
    struct Rows {
        PixelRun* runs = nullptr;
        std::uint32_t count = 0, capacity = 0;
    };
    // Pixels first .. end - 1 of the map, all in one row, and their step::triangle_id().
    struct LabelledRun {
        std::uint32_t first, end, id;
    };
    // What one thread works on in an update.
    struct ThreadWork {
        explicit ThreadWork(const step::PixelView& view) : components(view) {}
        BlockAllocator<PixelRun> runs;         // of all of them, those of before as well
        std::vector<std::uint32_t> triangles;  // that have other pixels than before
        std::vector<LabelledRun> labelled;     // of those with discontinuities
        TriangleComponents components;
        std::vector<PixelRun> buffer;  // for the pixels of one
        // triangles of which a lower one took pixels at the same time
        std::vector<std::uint32_t> overwritten;
    };
    std::span<const PixelRun> rows(std::uint32_t t) const { return {rows_[t].runs, rows_[t].count}; }
    bool rasterize(const SplitLattice& lattice, std::uint32_t t, ThreadWork& work);
    void label(const SplitLattice& lattice, std::uint32_t t, ThreadWork& work);
    void scan_pixels(std::uint32_t t);
    bool is_linked(const PixelRun& upper, const PixelRun& lower) const;
    void write_ids(std::uint32_t t, const std::vector<LabelledRun>& labelled, std::size_t& next);
    bool is_plain(std::uint32_t t) const { return plain_[t] && areas_[t] > 0; }
    bool is_closed_without_vote(const SplitLattice& lattice, std::uint32_t t) const;
    void vote(const SplitLattice& lattice, std::uint32_t t);
    step::EdgeVotes count_votes(const SplitLattice& lattice, std::uint32_t t) const;
    bool differ(std::uint32_t a, std::uint32_t b) const;
    bool is_overwritten(std::uint32_t t) const;
    double outlier_error(const TriangleComponents& components,
                         const TriangleComponents::Largest& largest) const;
    std::span<const PixelRun> fitted_rows(std::uint32_t t, ThreadWork& work);

    step::PixelView view_;
    float discontinuity_px_;
    double cell_px_, nearest_px_ = 0;
    ThreadPool& pool_;
    TriangleLabels labels_;
    RawVector<std::uint32_t> triangle_ids_;          // a pixel: step::triangle_id(), 0 = no triangle's
    RawVector<Rows> rows_;                           // a triangle: its pixels
    std::vector<ThreadWork> work_;                   // of each thread, during an update
    RawVector<std::uint8_t> renewed_;                // a triangle: whether its edges are to be voted on
    RawVector<std::uint32_t> label_pixels_, areas_;  // a triangle: first pixel of its label; how many pixels
    // a triangle: see step::is_closed_without_vote(); whether no discontinuity parts it; whether it has no
    // speckle
    RawVector<std::uint8_t> plain_, whole_, trusted_;
};

}  // namespace hexrelief::surface
