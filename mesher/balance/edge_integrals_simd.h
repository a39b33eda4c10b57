// The boundary edges of the honeycomb cells along a row of the lattice, several at once in vector registers.
#pragma once

#include "mesher/balance/edge_integrals_step.h"

namespace hexrelief::balance {

// Writes view.edges for the three edges of each class 1 vertex of the row, the same bits as step::edge_mass;
// 0 where an edge would leave the lattice. A plain loop over edge_mass takes 20 % more instructions in the
// whole mesh stage (small aloe, AVX2).
void measure_boundary_edges(const step::BalanceView& view, int row);

}  // namespace hexrelief::balance
