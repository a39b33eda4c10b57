#include "exporters/compression/quantized_streams.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "pipeline/data/bounds.h"
#include "pipeline/data/error.h"

namespace hexrelief::exporters {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kBitsWithoutCamera = 14;

template <typename T>
constexpr ComponentType component_type() {
    if constexpr (std::is_same_v<T, std::int8_t>) return ComponentType::int8;
    if constexpr (std::is_same_v<T, std::uint8_t>) return ComponentType::uint8;
    if constexpr (std::is_same_v<T, std::int16_t>) return ComponentType::int16;
    if constexpr (std::is_same_v<T, std::uint16_t>) return ComponentType::uint16;
    return ComponentType::float32;
}

// Builds a stream; value(vertex, component) gives every component.
template <typename T, typename Value>
VertexStream make_stream(std::size_t count, int components, const Value& value) {
    VertexStream out;
    out.count = count;
    out.components = components;
    out.type = component_type<T>();
    out.stride = (components * sizeof(T) + 3) / 4 * 4;
    out.bytes.assign(count * out.stride, 0);
    for (std::size_t i = 0; i < count; ++i)
        for (int k = 0; k < components; ++k) {
            const T v = static_cast<T>(value(i, k));
            std::memcpy(out.bytes.data() + i * out.stride + k * sizeof(T), &v, sizeof v);
        }
    return out;
}

float component(const Vec3f& v, int k) {
    return k == 0 ? v.x : k == 1 ? v.y : v.z;
}

VertexStream float_stream(const std::vector<Vec3f>& values) {
    return make_stream<float>(values.size(), 3,
                              [&](std::size_t i, int k) { return component(values[i], k); });
}

template <int N>
VertexStream grid_stream(const Grid<N>& grid) {
    const auto cell = [&](std::size_t i, int k) { return grid.cells[i][k]; };
    const int bits = grid.bits();
    return bits <= 8 ? make_stream<std::uint8_t>(grid.cells.size(), N, cell)
                     : make_stream<std::uint16_t>(grid.cells.size(), N, cell);
}

// Returns a grid of `bits` bits along the widest side of the positions' bounding box.
Grid<3> box_grid(const std::vector<Vec3f>& positions, int bits) {
    const Bounds bounds = bounds_of(positions);
    const Vec3f& low = bounds.low;
    const double side = bounds.widest_side();
    const double step = side > 0 ? side / ((1 << bits) - 1) : 1;
    Grid<3> grid{{low.x, low.y, low.z}, {step, step, step}, {}, {}};
    for (const Vec3f& p : positions) {
        const auto cell = [&](float value, float from) {
            return static_cast<std::int32_t>(std::lround((double(value) - from) / step));
        };
        grid.cells.push_back({cell(p.x, low.x), cell(p.y, low.y), cell(p.z, low.z)});
        for (int k = 0; k < 3; ++k) grid.largest[k] = std::max(grid.largest[k], grid.cells.back()[k]);
    }
    return grid;
}

// Returns the grid that keeps the tolerance; if there is none, a grid that needs more bits
// than 16-bit integers have.
Grid<3> fitting_grid(const SurfaceMesh& mesh, const Calibration& camera, double tolerance_px,
                     GridShape shape) {
    try {
        return quantise_positions(mesh, camera, tolerance_px, shape);
    } catch (const Error&) {
        Grid<3> none;
        none.largest = {1 << 24, 1 << 24, 1 << 24};
        return none;
    }
}

constexpr int kMostBits = 16;

Grid<3> finest_grid(const TexturedMesh& textured, const Calibration* camera, const ExportConfig& config,
                    bool meshopt) {
    const SurfaceMesh& mesh = textured.mesh;
    if (textured.grid_step_m > 0) return exact_grid(mesh.positions, textured.grid_step_m);
    if (!camera) return box_grid(mesh.positions, kBitsWithoutCamera);
    // Equal steps leave normals unchanged. Meshopt's coder needs fewer bytes if depths have a
    // step of their own.
    if (!meshopt) {
        Grid<3> grid = fitting_grid(mesh, *camera, config.tolerance_px, GridShape::cubic);
        if (grid.bits() <= kMostBits) return grid;
    }
    return fitting_grid(mesh, *camera, config.tolerance_px, GridShape::per_axis);
}

void add_positions(QuantizedMesh& out, const TexturedMesh& textured, const Calibration* camera,
                   const ExportConfig& config, bool meshopt) {
    const SurfaceMesh& mesh = textured.mesh;
    const std::optional<Grid<3>> fitting = position_grid(textured, camera, config, meshopt);
    if (!fitting) {
        out.positions = float_stream(mesh.positions);
        const auto [low, high] = bounds_of(mesh.positions);
        out.positions.low = {low.x, low.y, low.z};
        out.positions.high = {high.x, high.y, high.z};
        return;
    }
    const Grid<3>& grid = *fitting;
    out.transform = {grid.origin, grid.step};
    out.positions = grid_stream(grid);
    out.positions.low = {0, 0, 0};
    out.positions.high.assign(grid.largest.begin(), grid.largest.end());
}

// Checks that normals read back from the file, with its scale undone, are within the tolerance
// of the given ones.
class NormalCheck {
  public:
    NormalCheck(const std::vector<Vec3f>& wanted, const std::array<double, 3>& scale, double tolerance_deg)
        : wanted_(wanted), scale_(scale), least_cosine_(std::cos(tolerance_deg * kPi / 180)) {}
    template <typename T>
    bool serves(const VertexStream& stream) const {
        for (std::size_t i = 0; i < wanted_.size(); ++i) {
            T stored[3];
            std::memcpy(stored, stream.bytes.data() + i * stream.stride, sizeof stored);
            const double x = stored[0] / scale_[0], y = stored[1] / scale_[1], z = stored[2] / scale_[2];
            const Vec3f& n = wanted_[i];
            const double length = std::sqrt((x * x + y * y + z * z) *
                                            (double(n.x) * n.x + double(n.y) * n.y + double(n.z) * n.z));
            if (!(x * n.x + y * n.y + z * n.z >= least_cosine_ * length)) return false;
        }
        return true;
    }

  private:
    const std::vector<Vec3f>& wanted_;
    const std::array<double, 3>& scale_;
    double least_cosine_;
};

template <typename T>
VertexStream rounded_normals(const std::vector<Vec3f>& normals) {
    VertexStream out = make_stream<T>(normals.size(), 3, [&](std::size_t i, int k) {
        return std::lround(component(normals[i], k) * std::numeric_limits<T>::max());
    });
    out.normalized = true;
    return out;
}

VertexStream octahedral_normals(const std::vector<Vec3f>& normals, int bits) {
    std::vector<float> padded(4 * normals.size(), 0);
    for (std::size_t i = 0; i < normals.size(); ++i)
        for (int k = 0; k < 3; ++k) padded[4 * i + k] = component(normals[i], k);
    VertexStream out;
    out.count = normals.size();
    out.stride = bits <= 8 ? 4 : 8;
    out.type = bits <= 8 ? ComponentType::int8 : ComponentType::int16;
    out.normalized = out.octahedral = true;
    out.bytes.resize(out.count * out.stride);
    meshopt_encodeFilterOct(out.bytes.data(), out.count, out.stride, bits, padded.data());
    return out;
}

void add_normals(QuantizedMesh& out, const SurfaceMesh& mesh, double tolerance_deg, bool meshopt) {
    const std::array<double, 3>& scale = out.transform.scale;
    const NormalCheck check(mesh.normals, scale, tolerance_deg);
    const std::vector<Vec3f> stored = scaled_normals(mesh.normals, scale);
    const auto serves = [&](const VertexStream& stream) {
        return stream.type == ComponentType::int8 ? check.serves<std::int8_t>(stream)
                                                  : check.serves<std::int16_t>(stream);
    };
    for (int bits = 4; meshopt && bits <= 16; ++bits) {
        out.normals = octahedral_normals(stored, bits);
        VertexStream decoded = out.normals;
        meshopt_decodeFilterOct(decoded.bytes.data(), decoded.count, decoded.stride);
        if (serves(decoded)) return;
    }
    out.normals = rounded_normals<std::int8_t>(stored);
    if (serves(out.normals)) return;
    out.normals = rounded_normals<std::int16_t>(stored);
    if (serves(out.normals)) return;
    out.normals = float_stream(stored);
}

void add_texcoords(QuantizedMesh& out, const TexturedMesh& textured, double tolerance_px) {
    constexpr double kMost = std::numeric_limits<std::uint16_t>::max();
    const std::vector<Vec2f>& texcoords = textured.mesh.texcoords;
    const auto value = [&](std::size_t i, int k) { return k == 0 ? texcoords[i].x : texcoords[i].y; };
    const int longest = std::max(textured.width_px, textured.height_px);
    if (longest / (2 * tolerance_px) >= 0.99 * kMost) {
        out.texcoords = make_stream<float>(texcoords.size(), 2, value);
        return;
    }
    std::array<double, 2> scale = {1, 1};
    if (!textured.textured) {  // without a texture no transform can undo larger steps
        out.texcoords = make_stream<std::uint16_t>(
            texcoords.size(), 2, [&](std::size_t i, int k) { return std::lround(value(i, k) * kMost); });
    } else {
        const Grid<2> grid = quantise_texcoords(texcoords, textured.width_px, textured.height_px,
                                                tolerance_px, GridShape::per_axis);
        out.texcoords = make_stream<std::uint16_t>(texcoords.size(), 2,
                                                   [&](std::size_t i, int k) { return grid.cells[i][k]; });
        scale = {grid.step[0] * kMost, grid.step[1] * kMost};
    }
    out.texcoords.normalized = true;
    out.texcoord_scale = scale;
}

void reorder(VertexStream& stream, const std::vector<unsigned int>& order, std::size_t used) {
    if (stream.count == 0) return;
    std::vector<std::uint8_t> bytes(used * stream.stride);
    meshopt_remapVertexBuffer(bytes.data(), stream.bytes.data(), stream.count, stream.stride, order.data());
    stream.bytes = std::move(bytes);
    stream.count = used;
}

void order_for_meshopt(QuantizedMesh& out) {
    const std::size_t vertices = out.positions.count;
    std::vector<unsigned int> indices(out.indices.size()), order(vertices);
    meshopt_optimizeVertexCacheStrip(indices.data(), out.indices.data(), indices.size(), vertices);
    const std::size_t used =
        meshopt_optimizeVertexFetchRemap(order.data(), indices.data(), indices.size(), vertices);
    meshopt_remapIndexBuffer(out.indices.data(), indices.data(), indices.size(), order.data());
    for (VertexStream* stream : {&out.positions, &out.normals, &out.texcoords, &out.provenance})
        reorder(*stream, order, used);
}

}  // namespace

std::optional<Grid<3>> position_grid(const TexturedMesh& textured, const Calibration* camera,
                                     const ExportConfig& config, bool meshopt) {
    Grid<3> grid = finest_grid(textured, camera, config, meshopt);
    if (grid.bits() > kMostBits) return std::nullopt;
    return grid;
}

QuantizedMesh quantize_mesh(const TexturedMesh& textured, const Calibration* camera,
                            const ExportConfig& config, bool meshopt) {
    const SurfaceMesh& mesh = textured.mesh;
    QuantizedMesh out;
    add_positions(out, textured, camera, config, meshopt);
    if (!mesh.normals.empty()) add_normals(out, mesh, config.tolerance_deg, meshopt);
    if (!mesh.texcoords.empty()) add_texcoords(out, textured, config.tolerance_px);
    out.provenance = make_stream<std::uint8_t>(
        mesh.provenance.size(), 1, [&](std::size_t i, int) { return static_cast<int>(mesh.provenance[i]); });
    out.indices.reserve(3 * mesh.triangles.size());
    for (const Triangle& t : mesh.triangles) out.indices.insert(out.indices.end(), t.begin(), t.end());
    if (meshopt) order_for_meshopt(out);
    return out;
}

}  // namespace hexrelief::exporters
