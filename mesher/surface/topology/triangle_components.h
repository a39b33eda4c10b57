// The connected components of a triangle's pixels: neighbours, diagonal ones too, are connected where no
// discontinuity parts them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mesher/surface/topology/label_triangles_step.h"
#include "pipeline/data/union_find.h"

namespace hexrelief::surface {

// Reusable, because a vector of its own for each triangle would take longer than the search.
class TriangleComponents {
  public:
    struct Largest {
        std::uint32_t pixel = 0;  // its first one
        std::uint32_t area = 0;
        std::uint32_t segment = 0;  // that stands for it
    };

    explicit TriangleComponents(const step::PixelView& view) : view_(view) {}

    // Pixels of a row without a discontinuity between them.
    struct Segment {
        std::uint32_t first, end;
        std::uint32_t component;  // the first of its segments stands for it
        std::uint32_t area;       // of the component, in that first one
    };

    // rows: all of the triangle's, at least one pixel. Returns the largest component, the first of equal
    // ones.
    Largest find(std::span<const PixelRun> rows);
    // Of all the rows, in their order.
    std::span<const Segment> segments() const { return segments_; }

  private:
    void add_row(const PixelRun& run);
    void connect(const PixelRun& upper, std::size_t above, const PixelRun& lower, std::size_t below);
    void bridge(const PixelRun& upper, std::size_t above, const PixelRun& lower, std::size_t below);
    void meet(std::size_t above, std::uint32_t i, std::size_t below, std::uint32_t j);
    void join(std::size_t i, std::size_t j);

    step::PixelView view_;
    std::vector<Segment> segments_;
    UnionFind components_;  // of segments
};

}  // namespace hexrelief::surface
