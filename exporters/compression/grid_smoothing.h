// Chooses integer coordinates within each vertex's tolerance
// that minimise parallelogram-prediction residuals.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/data/surface_mesh.h"

namespace hexrelief::exporters {

struct CellRange {
    std::int32_t low = 0, high = 0;  // inclusive
};

// The pairs of triangles across whose common edge mesh coders predict: for an edge (a, b) of two triangles
// (a, b, c) and (b, a, d) the prediction is d = a + b - c.
class GridNeighbours {
  public:
    GridNeighbours(const std::vector<Triangle>& triangles, std::size_t vertex_count);
    // Chooses one coordinate of all vertices, each within its range: starts from the middles of
    // the ranges and lowers the sum of |a + b - c - d| over all inner edges, vertex by vertex in
    // their order, `sweeps` times.
    std::vector<std::int32_t> smooth(const std::vector<CellRange>& ranges, int sweeps) const;

  private:
    struct Term {
        // An inner edge has residual 0 if the vertex is plus1 + plus2 - minus.
        std::uint32_t plus1, plus2, minus;
    };
    std::vector<std::uint32_t> starts_;  // terms of vertex v: starts_[v] .. starts_[v + 1] - 1
    std::vector<Term> terms_;
};

}  // namespace hexrelief::exporters
