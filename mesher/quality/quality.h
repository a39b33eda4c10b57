// Quality of a structured hexagonal mesh: the paper's %cost (Eq. 1 and 2), validity and shape; and the exact
// integrals of the density that it needs.
#pragma once

#include <array>
#include <vector>

#include "pipeline/data/density_map.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief::quality {

struct MeshQuality {
    double percent_cost = 0;           // Eq. 2 over the honeycomb cells, with exact pixel coverage
    double max_deviation_percent = 0;  // largest |W_k - W| / W x 100
    int honeycomb_cells = 0;           // K, the number of honeycomb cells
    long long inverted_triangles = 0;  // number with signed area <= 0
    double min_angle_deg = 0;          // smallest angle of all triangles
    double percentile1_angle_deg = 0;  // 1st percentile of the triangles' smallest angles
    double median_angle_deg = 0;       // median of the triangles' smallest angles
    // Percentiles of W_k / W x 100. Percentile p of n values is the one with floor(n p /
    // 100) values below it.
    double percentile5_weight_percent = 0;
    double percentile50_weight_percent = 0;
    double percentile95_weight_percent = 0;
};

// Returns W_k of every honeycomb cell, row by row of their centres (paper, section 2.2, Fig. 1): the integral
// of the density over the six triangles around the centre. Centres are the lattice vertices with six
// neighbours and (q - r) mod 3 = 0 in axial coordinates.
std::vector<double> honeycomb_weights(const HexMesh2D& mesh, const DensityMap& density, int threads);

// Measures a mesh on the density of its image in O(pixels). percent_cost and the weights' percentiles are 0
// if the density is 0 everywhere or there is no honeycomb cell.
MeshQuality measure_quality(const HexMesh2D& mesh, const DensityMap& density, int threads);

// Exact integrals of the density over the lattice's triangles, computed along their edges (Green's theorem).
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
