#include "exporters/inspect/gltf_places.h"

namespace hexrelief::inspect {
namespace {

using Json = nlohmann::json;

template <std::size_t N>
std::array<double, N> numbers(const Json& node, const char* key, std::array<double, N> fallback) {
    const auto it = node.find(key);
    return it == node.end() ? fallback : it->get<std::array<double, N>>();
}

Matrix own_matrix(const Json& node) {
    Matrix out;
    if (node.contains("matrix")) {
        const auto m = node["matrix"].get<std::array<double, 16>>();  // column by column
        for (std::size_t r = 0; r < 3; ++r)
            for (std::size_t c = 0; c < 4; ++c) out.rows[r][c] = m[4 * c + r];
        return out;
    }
    const auto t = numbers<3>(node, "translation", {0, 0, 0}), s = numbers<3>(node, "scale", {1, 1, 1});
    const auto [x, y, z, w] = numbers<4>(node, "rotation", {0, 0, 0, 1});
    const double rotation[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
                                   {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
                                   {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}};
    for (std::size_t r = 0; r < 3; ++r) {
        for (std::size_t c = 0; c < 3; ++c) out.rows[r][c] = rotation[r][c] * s[c];
        out.rows[r][3] = t[r];
    }
    return out;
}

class Walk {
  public:
    Walk(const Json& nodes, std::size_t meshes)
        : nodes_(nodes), on_path_(nodes.size(), false), places(meshes) {}
    // Collects the transforms of a node and its descendants. Stops at a node on its own path, which would be
    // walked for ever; after kMostVisits, because shared children can be reached on 2^n paths; and kDeepest
    // levels below the scene, before the stack overflows.
    void visit(const Json& index, const Matrix& outer, int depth = 0) {
        if (!index.is_number_unsigned() || index.get<std::size_t>() >= nodes_.size() ||
            ++visited_ > kMostVisits || depth > kDeepest)
            return;
        const std::size_t i = index.get<std::size_t>();
        if (on_path_[i] || !nodes_[i].is_object()) return;
        on_path_[i] = true;
        const Json& node = nodes_[i];
        const Matrix matrix = outer * own_matrix(node);
        if (const auto mesh = node.find("mesh");
            mesh != node.end() && mesh->is_number_unsigned() && mesh->get<std::size_t>() < places.size())
            places[mesh->get<std::size_t>()].push_back(matrix);
        if (const auto children = node.find("children"); children != node.end())
            for (const Json& child : *children) visit(child, matrix, depth + 1);
        on_path_[i] = false;
    }

  private:
    static constexpr int kMostVisits = 100000, kDeepest = 1000;
    const Json& nodes_;
    std::vector<bool> on_path_;
    int visited_ = 0;

  public:
    std::vector<std::vector<Matrix>> places;
};

}  // namespace

Vec3f Matrix::apply(const Vec3f& p) const {
    const auto row = [&](std::size_t r) {
        return static_cast<float>(rows[r][0] * p.x + rows[r][1] * p.y + rows[r][2] * p.z + rows[r][3]);
    };
    return {row(0), row(1), row(2)};
}

Matrix operator*(const Matrix& outer, const Matrix& inner) {
    Matrix out;
    for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t c = 0; c < 4; ++c) {
            out.rows[r][c] = c == 3 ? outer.rows[r][3] : 0;
            for (std::size_t k = 0; k < 3; ++k) out.rows[r][c] += outer.rows[r][k] * inner.rows[k][c];
        }
    return out;
}

std::vector<std::vector<Matrix>> mesh_places(const Json& document, std::size_t meshes) {
    const auto nodes = document.find("nodes"), scenes = document.find("scenes");
    std::vector<std::vector<Matrix>> places(meshes);
    if (nodes != document.end() && nodes->is_array() && scenes != document.end() && scenes->is_array()) {
        const std::size_t scene = document.value("scene", std::size_t{0});
        Walk walk(*nodes, meshes);
        if (scene < scenes->size() && (*scenes)[scene].is_object())
            for (const Json& root : (*scenes)[scene].value("nodes", Json::array())) walk.visit(root, {});
        places = std::move(walk.places);
    }
    for (auto& of_mesh : places)
        if (of_mesh.empty()) of_mesh.emplace_back();
    return places;
}

}  // namespace hexrelief::inspect
