// The undeformed lattice.
#pragma once

#include "mesher/som/level_plan.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief::mesher {

// Returns a lattice of max(3, round(size / spacing)) columns and rows over an image of width x height px.
inline HexMesh2D regular_lattice(int width, int height, double spacing_px) {
    const step::Lattice lattice = som::lattice_size(width, height, spacing_px);
    HexMesh2D mesh{lattice.columns, lattice.rows, {}};
    for (int row = 0; row < lattice.rows; ++row)
        for (int column = 0; column < lattice.columns; ++column)
            mesh.positions.push_back(
                {step::regular_x(column, row, lattice.columns, static_cast<float>(width)),
                 step::regular_y(row, lattice.rows, static_cast<float>(height))});
    return mesh;
}

}  // namespace hexrelief::mesher
