// Finds where the nodes of a glTF document place its meshes.
#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <vector>

#include "pipeline/data/geometry.h"

namespace hexrelief::inspect {

// An affine transform, row by row: each row is multiplied by the point (x, y, z, 1).
struct Matrix {
    std::array<std::array<double, 4>, 3> rows = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    Vec3f apply(const Vec3f& p) const;
};
Matrix operator*(const Matrix& outer, const Matrix& inner);

// Returns for each mesh the transforms of the nodes of the default scene that show it. A mesh that no
// such node shows has one transform, the identity, and so has every mesh if there is no scene. Indices
// outside their arrays are skipped, and so are nodes that are their own descendants. Members of wrong
// types throw nlohmann's exceptions.
std::vector<std::vector<Matrix>> mesh_places(const nlohmann::json& document, std::size_t meshes);

}  // namespace hexrelief::inspect
