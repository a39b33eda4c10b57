// Vertices along silhouettes moved so that the edges between them fit the pixel sides with a discontinuity.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/surface/fit/fit_silhouettes_step.h"
#include "mesher/surface/fit/silhouette_samples.h"
#include "mesher/surface/topology/label_triangles.h"
#include "pipeline/data/counting_sort.h"

namespace hexrelief::surface {

// Between two fits a lattice may be split, its vertices keep their numbers and stay.
class SilhouetteFitter {
  public:
    SilhouetteFitter(const PixelSurfaces& surfaces, ThreadPool& pool);
    // Moves the vertices of silhouettes by least squares; by less where a triangle would become thin. The
    // labels stay right but for the pixels that the silhouettes pass over.
    void fit(const TriangleLabels& labels, SplitLattice& lattice);

  private:
    struct Edge {
        std::uint32_t a = 0, b = 0;
        std::uint32_t slot = 0;    // 3 * triangle + corner that it begins at
        float nx = 0, ny = 0;      // unit, to the left
        bool seen = false;         // whether what follows is known
        Vec2f at_a{}, at_b{};      // where its vertices were when its residuals were summed
        Vec2f from_a{}, from_b{};  // and when its sides were found
        SilhouetteSamples samples{};
        step::SilhouetteResiduals residuals{};
    };
    struct SilhouetteTriangle {
        std::uint32_t number;
        // px2: while no corner is farther from where it started, the triangle allows whatever they do.
        float slack2;
    };
    // A thread's.
    struct ThreadWork {
        SilhouetteSampler sampler;
        std::vector<Edge> edges;                    // found in its share of triangles
        std::size_t first;                          // of them, among all
        std::vector<SilhouetteTriangle> triangles;  // at silhouettes
    };

    class ThreadLoops;

    void gather_edges(const TriangleLabels& labels, const SplitLattice& lattice);
    void move_vertices(SplitLattice& lattice, ThreadLoops& loops);
    void mark_moved(SplitLattice& lattice, std::uint32_t t) const;
    void find_edges(const TriangleLabels& labels, const SplitLattice& lattice, int thread);
    void number_vertices(const SplitLattice& lattice);
    void find_triangles(const SplitLattice& lattice, int thread);
    void find_ends();
    bool has_moved(const Edge& edge) const { return moved_[index_[edge.a]] || moved_[index_[edge.b]]; }
    bool has_moved_around(std::size_t i) const;
    void find_residuals(const std::vector<Vec2f>& points, Edge& edge, SilhouetteSampler& sampler) const;
    Vec2f target(const Vec2f& from, std::size_t i) const;
    void hold_corners(const std::vector<Vec2f>& points, const Triangle& n);

    step::PixelView view_;
    ThreadPool& pool_;
    std::vector<ThreadWork> work_;
    RawVector<Edge> edges_, before_;             // of this fit, of the one before
    std::vector<std::uint32_t> slots_;           // where an edge was in before_, if one of that slot is there
    std::vector<std::uint32_t> vertices_;        // on silhouettes
    std::vector<std::uint32_t> index_;           // a vertex: where it is among them
    std::vector<SilhouetteTriangle> triangles_;  // with such a vertex
    Buckets ends_;                               // at each silhouette vertex: 2 * edge + which
    RawVector<Vec2f> targets_;                   // of all vertices
    std::vector<float> far2_;    // px2, of all: how far from their starts they ever wanted to go
    std::vector<Vec2f> starts_;  // of silhouette vertices, when the fit began
    std::vector<std::uint8_t> moved_, marked_;  // silhouette vertices: in the round before; ever
    std::vector<std::uint8_t> held_;            // silhouette vertices: by a triangle
};

}  // namespace hexrelief::surface
