// Where the nodes of a glTF document place its meshes.
#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <vector>

#include "pipeline/data/geometry.h"

namespace hexrelief::inspect {

// Row by row: the point (x, y, z, 1) times each.
struct Matrix {
    std::array<std::array<double, 4>, 3> rows = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    Vec3f apply(const Vec3f& p) const;
};
Matrix operator*(const Matrix& outer, const Matrix& inner);

// For each mesh the places of the nodes of the default scene that show it. A mesh that no such node shows has
// one place, as it is, and so has every mesh where there is no scene. Members of wrong types throw nlohmann's
// exceptions; indices outside their arrays and nodes below themselves are passed over.
std::vector<std::vector<Matrix>> mesh_places(const nlohmann::json& document, std::size_t meshes);

}  // namespace hexrelief::inspect
