// Integrals along the boundary edges of the honeycomb cells, several edges at a time in SIMD batches.
#pragma once

#include "mesher/balance/edge_integrals_step.h"

namespace hexrelief::balance {

// Writes view.edges for the three edges of each class 1 vertex of the row, with the same bits as
// step::edge_mass(); 0 for an edge that would leave the lattice. A plain loop over edge_mass() takes 20 %
// more instructions in the whole mesh stage (small aloe, AVX2).
void measure_boundary_edges(const step::BalanceView& view, int row);

}  // namespace hexrelief::balance
