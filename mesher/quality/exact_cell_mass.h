// Exact integrals of the density over the lattice's triangles, through their edges (Green's theorem).
#pragma once

#include <array>
#include <vector>

#include "pipeline/data/density_map.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief::quality {

// The integral of density over a polygon is the sum over its edges of the integral of P(x, y) dy, where P is
// the density's primitive along its row. Each edge is integrated once and serves the triangles on both of its
// sides, so the cost is that of the pixels that edges cross, not of those that triangles cover.
class EdgeMasses {
  public:
    EdgeMasses(const HexMesh2D& mesh, const DensityMap& density, int threads);
    // W_k of the honeycomb cell centred at a vertex whose six neighbours exist: |mass| summed over its six
    // triangles.
    double honeycomb(int column, int row) const;

  private:
    int columns_;
    // integrals from a vertex to its neighbours 0 (east), 1 and 2 (next row); 0 where there is none
    std::vector<std::array<double, 3>> mass_;
};

}  // namespace hexrelief::quality
