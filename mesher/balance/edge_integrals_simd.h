// The silhouette edges of a row of the lattice, measured several at once on the CPU.
#pragma once

#include "mesher/balance/edge_integrals_step.h"

namespace hexrelief {

// As step::measure_silhouette_edge for the three edges of each vertex of class 1 in the row, to the bit.
void measure_silhouette_edges(const step::BalanceView& view, int row);

}  // namespace hexrelief
