// Exact integrals of the density over the lattice's triangles, computed along their edges (Green's theorem).
#pragma once

#include <array>
#include <vector>

#include "pipeline/data/density_map.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief::quality {

// The integral of the density over a polygon is the sum over its edges of the integral of P(x, y) dy, with P
// the density's primitive along its row. Each edge is integrated once and serves the triangles on both of its
// sides, so the cost depends on the pixels that edges cross, not on those that triangles cover.
class EdgeMasses {
  public:
    EdgeMasses(const HexMesh2D& mesh, const DensityMap& density, int threads);
    // Returns W_k of the honeycomb cell around a vertex with six neighbours: the sum of |mass|
    // over its six triangles.
    double honeycomb(int column, int row) const;

  private:
    int columns_;
    // Integrals from a vertex to its neighbours 0 (east), 1 and 2 (next row); 0 for a neighbour
    // that does not exist.
    std::vector<std::array<double, 3>> mass_;
};

}  // namespace hexrelief::quality
