// Of the whole numbers that keep each vertex within its tolerance, those that a parallelogram predictor
// guesses best.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/data/surface_mesh.h"

namespace hexrelief::exporters {

struct CellRange {
    std::int32_t low = 0, high = 0;  // inclusive
};

// Mesh coders predict across an edge (a, b) of two triangles (a, b, c) and (b, a, d): d = a + b - c.
class GridNeighbours {
  public:
    GridNeighbours(const std::vector<Triangle>& triangles, std::size_t vertex_count);
    // One coordinate of all vertices, each within its range: starts from the ranges' middles and lowers the
    // sum of |a + b - c - d| over all inner edges, vertex by vertex in their order.
    std::vector<std::int32_t> smooth(const std::vector<CellRange>& ranges, int sweeps) const;

  private:
    struct Term {
        std::uint32_t plus1, plus2,
            minus;  // an inner edge is content where the vertex is plus1 + plus2 - minus
    };
    std::vector<std::uint32_t> starts_;  // terms of vertex v: starts_[v] .. starts_[v + 1]
    std::vector<Term> terms_;
};

}  // namespace hexrelief::exporters
