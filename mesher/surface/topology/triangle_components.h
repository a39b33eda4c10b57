// Finds the connected components of a triangle's pixels: neighbours, also diagonal ones, are connected if no
// discontinuity lies between them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mesher/surface/topology/label_triangles_step.h"
#include "pipeline/data/union_find.h"

namespace hexrelief::surface {

// Is reused for many triangles, because allocating for each triangle would take longer than the search.
class TriangleComponents {
  public:
    struct Largest {
        std::uint32_t pixel = 0;  // the component's first pixel
        std::uint32_t area = 0;
        std::uint32_t segment = 0;  // index of the segment that stands for the component
    };

    explicit TriangleComponents(const step::PixelView& view) : view_(view) {}

    // Successive pixels of a row without a discontinuity between them.
    struct Segment {
        std::uint32_t first, end;
        std::uint32_t component;  // index of the segment that stands for its component
        std::uint32_t area;       // area of the component, stored in that segment
    };

    // Finds the components of the triangle with these rows, which must hold at least one pixel. Returns the
    // largest one, the first of equal ones.
    Largest find(std::span<const PixelRun> rows);
    // Returns the segments of all rows, in order.
    std::span<const Segment> segments() const { return segments_; }

  private:
    void add_row(const PixelRun& run);
    void connect(const PixelRun& upper, std::size_t above, const PixelRun& lower, std::size_t below);
    void bridge(const PixelRun& upper, std::size_t above, const PixelRun& lower, std::size_t below);
    void meet(std::size_t above, std::uint32_t i, std::size_t below, std::uint32_t j);
    void join(std::size_t i, std::size_t j);

    step::PixelView view_;
    std::vector<Segment> segments_;
    UnionFind components_;  // sets of indices of segments
};

}  // namespace hexrelief::surface
