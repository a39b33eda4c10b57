// The pieces of a triangle: pixels that hang together, diagonally too, where no jump parts them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mesher/steps/rim.h"
#include "mesher/steps/triangle_pixels.h"

namespace hexrelief {

// Reusable, because a vector of its own for each triangle would take longer than the search.
class TrianglePieces {
  public:
    struct Largest {
        std::uint32_t pixel = 0;  // its first one
        std::uint32_t area = 0;
    };

    explicit TrianglePieces(const step::PixelView& view) : view_(view) {}

    // Writes to each of the triangle's pixels the first one of its piece; rows: all of them, at least one
    // pixel. Returns the largest piece, the first of equal ones.
    Largest find(std::span<const PixelRun> rows, std::vector<std::uint32_t>& piece);

  private:
    // Pixels of a row without a jump between them, and the segment that stands for its piece: an earlier one,
    // or itself.
    struct Segment {
        std::uint32_t first, end, parent;
        std::uint32_t area;  // of the piece
    };
    void add_row(const PixelRun& run);
    void connect(const PixelRun& upper, std::size_t above, const PixelRun& lower, std::size_t below);
    void bridge(const PixelRun& upper, std::size_t above, const PixelRun& lower, std::size_t below);
    std::uint32_t root(std::uint32_t i);
    void join(std::size_t i, std::size_t j);

    step::PixelView view_;
    std::vector<Segment> segments_;
};

}  // namespace hexrelief
