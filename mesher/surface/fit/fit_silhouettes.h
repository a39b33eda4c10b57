// Moves vertices along silhouettes so that the mesh edges between them fit the crack edges around, and insets
// silhouettes at high depth discontinuities into their own surfaces.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "mesher/surface/fit/fit_silhouettes_step.h"
#include "mesher/surface/pixels/pixel_surfaces.h"
#include "mesher/surface/topology/cut_vertices.h"
#include "mesher/surface/topology/label_triangles.h"
#include "pipeline/base/thread_pool.h"
#include "pipeline/base/uninitialized_vector.h"
#include "pipeline/data/counting_sort.h"
#include "pipeline/data/disparity_map.h"

namespace hexrelief::surface {

// Samples as a structure of arrays, so that loops over them vectorise: x, y, near_x and near_y of all
// samples, one array after the other, padded to a multiple of kSamplesAtOnce with samples of weight 0.
inline constexpr int kSamplesAtOnce = 8;
struct SilhouetteSamples {
    const float* values = nullptr;
    int count = 0;  // number of items in each array
};

// One thread's samples, whose addresses stay valid, and its buffers.
class SilhouetteSampler {
  public:
    explicit SilhouetteSampler(const step::PixelView& view) : view_(view) {}

    // Finds all samples within reach_px of the edge p -> q, and a few more; they live as long as the sampler.
    SilhouetteSamples find(const Vec2f& p, const Vec2f& q, float reach_px);
    // Returns the sums of the edge's residuals to the samples.
    step::SilhouetteResiduals residuals(const step::SilhouetteEdgeFrame& edge,
                                        const SilhouetteSamples& samples);

  private:
    step::PixelView view_;
    BlockAllocator<float> found_;
    std::vector<step::SilhouetteSample> buffer_;  // samples being found
    std::vector<float> residuals_;                // of one edge, as a structure of arrays
    std::vector<std::uint32_t> weighing_;         // indices of its samples with a weight
};

// May be used again after the lattice has been split further: vertices must keep their numbers and positions.
class SilhouetteFitter {
  public:
    SilhouetteFitter(const PixelSurfaces& surfaces, ThreadPool& pool);
    // Moves the silhouettes' vertices by least squares, by less if a triangle would become thin. The labels
    // stay valid except for the pixels that the silhouettes pass over.
    void fit(const TriangleLabels& labels, SplitLattice& lattice);

  private:
    struct Edge {
        std::uint32_t a = 0, b = 0;
        std::uint32_t slot = 0;    // 3 * triangle + the corner at which it begins
        float nx = 0, ny = 0;      // unit normal, towards that triangle
        bool seen = false;         // true if the following members are valid
        Vec2f at_a{}, at_b{};      // positions of its vertices when its residuals were summed
        Vec2f from_a{}, from_b{};  // positions of its vertices when its samples were found
        SilhouetteSamples samples{};
        step::SilhouetteResiduals residuals{};
    };
    struct SilhouetteTriangle {
        std::uint32_t number;
        // px2: while no corner is farther from its start, the corners may move in any way without
        // making the triangle thin.
        float slack2;
    };
    // The working memory of one thread.
    struct ThreadWork {
        SilhouetteSampler sampler;
        std::vector<Edge> edges;                    // edges in its share of the triangles
        std::size_t first;                          // index of the first of them among all edges
        std::vector<SilhouetteTriangle> triangles;  // its triangles at silhouettes
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
    RawVector<Edge> edges_, before_;             // of this fit, of the preceding one
    std::vector<std::uint32_t> slots_;           // per slot: index of its edge in before_, if there is one
    std::vector<std::uint32_t> vertices_;        // vertices on silhouettes
    std::vector<std::uint32_t> index_;           // per vertex: its index in vertices_
    std::vector<SilhouetteTriangle> triangles_;  // triangles with three such vertices
    Buckets ends_;                               // per silhouette vertex: 2 * edge + which end
    RawVector<Vec2f> targets_;                   // per vertex of the lattice
    // px2, per vertex of the lattice: its targets' largest squared distance from its start
    std::vector<float> far2_;
    std::vector<Vec2f> starts_;  // per silhouette vertex: its position when the fit began
    // per silhouette vertex: moved in the last round; moved in any round
    std::vector<std::uint8_t> moved_, marked_;
    std::vector<std::uint8_t> held_;  // per silhouette vertex: held back by a triangle
};

// Moves the copies of a vertex at a high depth discontinuity apart, by `by_px` each, into their own surfaces,
// unless that uncovered a pixel that is not next to a high step. (At a step down to the background there is
// only one copy.) fans: fans of the lattice that `cut` comes from.
void inset_silhouettes(const PixelSurfaces& surfaces, const DisparityMap& map, double by_px,
                       const LatticeFans& fans, CutTriangles& cut, ThreadPool& pool);

}  // namespace hexrelief::surface
