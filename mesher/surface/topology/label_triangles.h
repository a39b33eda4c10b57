// Labels each triangle of the split lattice with the surface that it lies on, and finds the edges across
// which the surfaces differ.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/surface/pixels/pixel_surfaces.h"
#include "mesher/surface/topology/label_triangles_step.h"
#include "mesher/surface/topology/rasterize_step.h"
#include "mesher/surface/topology/split_triangles.h"
#include "mesher/surface/topology/triangle_components.h"
#include "pipeline/base/thread_pool.h"
#include "pipeline/base/uninitialized_vector.h"

namespace hexrelief::surface {

// The arrays are indexed by triangle, if nothing else is said.
struct TriangleLabels {
    RawVector<std::uint8_t> kept;      // true if the triangle lies on the foreground
    RawVector<std::uint32_t> anchors;  // a pixel of its label, or the pixel at its centre if it has none
    // The pixels that its surface is fitted to, row by row, some rows empty; TriangleLabeler owns them.
    RawVector<std::span<const PixelRun>> fitted;
    RawVector<std::uint8_t> straddling;  // true if its outliers cost too much
    // True for an edge across which the surfaces differ. Only the entry of an edge's lower triangle is valid.
    RawVector<std::array<std::uint8_t, 3>> open;
    RawVector<unsigned> cuts;  // per vertex: number of cut edges at it, by join_cuts()
};

// Gives each triangle the surface that most of its pixels belong to. The edge between two triangles is open
// if most pairs of pixels along it lie on different surfaces.
class TriangleLabeler {
  public:
    // cell_px: area of a lattice cell; nearest_px: disparity of the whole map that counts along with this
    // map's when the largest one is taken.
    TriangleLabeler(const PixelSurfaces& surfaces, double cell_px, float nearest_px, ThreadPool& pool);
    // Labels the triangles that have changed, and clears `changed`. Leaves their edges as they are.
    void update(SplitLattice& lattice);
    // Votes on the edges of the triangles that have changed since the last call, and
    // on their neighbours' edges.
    void open_edges(const SplitLattice& lattice);
    // Opens the closed edges between the ends of two cuts; to be called after the last open_edges().
    void join_cuts(const SplitLattice& lattice);
    // Fills in `fitted` for the labels of the last update.
    void collect_pixels(const SplitLattice& lattice);
    const TriangleLabels& labels() const { return labels_; }

  private:
    // The pixels of a triangle, a run per row.
    struct Rows {
        PixelRun* runs = nullptr;
        std::uint32_t count = 0, capacity = 0;
    };
    // Pixels first .. end - 1 of the map, all in one row, with their step::triangle_id().
    struct LabelledRun {
        std::uint32_t first, end, id;
    };
    // One thread's working memory in an update.
    struct ThreadWork {
        explicit ThreadWork(const step::PixelView& view) : components(view) {}
        BlockAllocator<PixelRun> runs;         // memory of all runs, including those of earlier updates
        std::vector<std::uint32_t> triangles;  // triangles whose pixels have changed
        std::vector<LabelledRun> labelled;     // runs of the triangles with discontinuities
        TriangleComponents components;
        std::vector<PixelRun> buffer;  // for the pixels of one triangle
        // triangles that lost pixels to a lower one in a race
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
    RawVector<std::uint32_t> triangle_ids_;  // per pixel: step::triangle_id(), 0 = in no triangle
    RawVector<Rows> rows_;                   // per triangle: its pixels
    std::vector<ThreadWork> work_;           // per thread, during an update
    RawVector<std::uint8_t> renewed_;        // per triangle: true if its edges have to be voted on
    // per triangle: first pixel of its label; number of pixels
    RawVector<std::uint32_t> label_pixels_, areas_;
    // Per triangle: plain, see step::is_closed_without_vote(); whole: no discontinuity divides its pixels;
    // trusted: none of its pixels is of a speckle.
    RawVector<std::uint8_t> plain_, whole_, trusted_;
};

}  // namespace hexrelief::surface
