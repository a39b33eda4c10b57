#include "exporters/compression/draco_codec.h"

#include <draco/compression/attributes/normal_compression_utils.h>
#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>
#include <draco/core/quantization_utils.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <new>
#include <stdexcept>
#include <utility>

#include "exporters/compression/draco_stream.h"
#include "pipeline/data/error.h"
#include "pipeline/data/number_text.h"
#include "pipeline/data/start_work.h"

namespace hexrelief::exporters {
namespace {

using draco::GeometryAttribute;

// Adds an attribute with one value per vertex (point i = vertex i), not yet set.
template <typename T>
void add_attribute(draco::Mesh& mesh, GeometryAttribute::Type type, const std::vector<T>& values) {
    if (values.empty()) return;
    constexpr int components = sizeof(T) / sizeof(float);
    GeometryAttribute attribute;
    attribute.Init(type, nullptr, components, draco::DT_FLOAT32, false, sizeof(T), 0);
    mesh.AddAttribute(attribute, true, static_cast<draco::AttributeValueIndex::ValueType>(values.size()));
}

template <typename T>
void set_values(draco::Mesh& mesh, GeometryAttribute::Type type, const std::vector<T>& values) {
    if (values.empty()) return;
    const int index = mesh.GetNamedAttributeId(type);
    mesh.attribute(index)->buffer()->Write(0, values.data(), values.size() * sizeof(T));
}

// Returns the grid's values as floats, from which Draco computes the same cells.
template <typename T, int N>
std::vector<T> values_of(const Grid<N>& grid) {
    std::vector<T> out(grid.cells.size());
    for (std::size_t i = 0; i < out.size(); ++i) {
        out[i].x = static_cast<float>(grid.value(i, 0));
        out[i].y = static_cast<float>(grid.value(i, 1));
        if constexpr (N == 3) out[i].z = static_cast<float>(grid.value(i, 2));
    }
    return out;
}

void add_triangles_and_attributes(draco::Mesh& out, const SurfaceMesh& mesh) {
    out.set_num_points(static_cast<std::uint32_t>(mesh.positions.size()));
    out.SetNumFaces(mesh.triangles.size());
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const Triangle& t = mesh.triangles[i];
        out.SetFace(draco::FaceIndex(static_cast<std::uint32_t>(i)),
                    {draco::PointIndex(t[0]), draco::PointIndex(t[1]), draco::PointIndex(t[2])});
    }
    add_attribute(out, GeometryAttribute::POSITION, mesh.positions);
    add_attribute(out, GeometryAttribute::NORMAL, mesh.normals);
    add_attribute(out, GeometryAttribute::TEX_COORD, mesh.texcoords);
}

void set_all_values(draco::Mesh& out, const SurfaceMesh& mesh, const DracoQuantisation& quantisation) {
    set_values(out, GeometryAttribute::POSITION,
               quantisation.positions ? values_of<Vec3f>(*quantisation.positions) : mesh.positions);
    set_values(out, GeometryAttribute::NORMAL, mesh.normals);
    set_values(out, GeometryAttribute::TEX_COORD,
               quantisation.texcoords ? values_of<Vec2f>(*quantisation.texcoords) : mesh.texcoords);
}

int unique_id(const draco::PointCloud& cloud, GeometryAttribute::Type type) {
    const draco::PointAttribute* attribute = cloud.GetNamedAttribute(type);
    return attribute ? static_cast<int>(attribute->unique_id()) : -1;
}

// Computes the bounds of the decoded positions. False if there are none.
bool bounds(const draco::PointCloud& cloud, Vec3f& low, Vec3f& high) {
    const draco::PointAttribute* positions = cloud.GetNamedAttribute(GeometryAttribute::POSITION);
    if (!positions || positions->num_components() != 3 || cloud.num_points() == 0) return false;
    for (std::uint32_t i = 0; i < cloud.num_points(); ++i) {
        const draco::AttributeValueIndex value = positions->mapped_index(draco::PointIndex(i));
        std::array<float, 3> p = {};
        if (!positions->ConvertValue<float, 3>(value, p.data())) return false;
        if (i == 0) low = high = {p[0], p[1], p[2]};
        low = {std::min(low.x, p[0]), std::min(low.y, p[1]), std::min(low.z, p[2])};
        high = {std::max(high.x, p[0]), std::max(high.y, p[1]), std::max(high.z, p[2])};
    }
    return true;
}

std::unique_ptr<draco::PointCloud> decode(const char* data, std::size_t size, std::string& reason,
                                          bool& is_mesh) {
    try {
        draco::DecoderBuffer buffer;
        buffer.Init(data, size);
        const auto type = draco::Decoder::GetEncodedGeometryType(&buffer);
        if (!type.ok()) {
            reason = type.status().error_msg_string();
            return nullptr;
        }
        is_mesh = type.value() == draco::TRIANGULAR_MESH;
        draco::Decoder decoder;
        auto decoded = decoder.DecodePointCloudFromBuffer(&buffer);
        if (!decoded.ok()) {
            reason = decoded.status().error_msg_string();
            return nullptr;
        }
        return std::move(decoded).value();
    } catch (const std::bad_alloc&) {
        reason = "its header asks for more memory than there is";
    } catch (const std::length_error&) {
        reason = "its header asks for more memory than there is";
    }
    return nullptr;
}

// True if the values that a decoder will return keep the tolerance.
bool keeps_tolerance(const DracoPlan& plan, const TexturedMesh& textured, const Calibration* camera,
                     double tolerance_px) {
    const DracoQuantisation& q = plan.quantisation;
    if (q.positions && camera &&
        !(position_error_px(plan.mesh, *camera, *q.positions, plan.transform, q.exact_boxes) <= tolerance_px))
        return false;
    return !q.texcoords || texcoord_error_px(plan.mesh.texcoords, textured.width_px, textured.height_px,
                                             *q.texcoords, q.exact_boxes) <= tolerance_px;
}

float in_six_decimals(float value) {
    return std::strtof(std::to_string(value).c_str(), nullptr);
}

// The values that a decoder returns for a grid's values.
template <int N>
class Decoded {
  public:
    Decoded(const Grid<N>& grid, bool exactly) : grid_(grid), box_(box_of(grid, exactly)) {
        const auto most = static_cast<std::int32_t>((1u << box_.bits) - 1);
        is_box_ = std::isnormal(box_.range) && std::isnormal(static_cast<float>(most) / box_.range) &&
                  decoder_.Init(box_.range, most);
        if (is_box_) encoder_.Init(box_.range, most);
    }
    bool is_box() const { return is_box_; }
    float operator()(std::size_t vertex, int axis) const {
        const auto given = static_cast<float>(grid_.value(vertex, axis));
        return decoder_(encoder_(given - box_.origin[axis])) + box_.origin[axis];
    }

  private:
    const Grid<N>& grid_;
    DracoBox box_;
    bool is_box_;
    draco::Quantizer encoder_;
    draco::Dequantizer decoder_;
};

}  // namespace

DracoMesh encode_draco(const SurfaceMesh& mesh, int level, const std::function<DracoValues()>& find,
                       int threads) {
    draco::Mesh input;  // can be neither copied nor moved
    add_triangles_and_attributes(input, mesh);
    const auto found = start_work(threads, [&] {
                           const DracoValues values = find();
                           set_all_values(input, *values.mesh, *values.quantisation);
                           return values.quantisation;
                       }).share();
    return write_draco_stream(
        input, level, [found]() -> const DracoQuantisation& { return *found.get(); }, threads);
}

int draco_normal_bits(const std::vector<Vec3f>& normals, const std::array<double, 3>& scale,
                      double tolerance_deg) {
    constexpr double kPi = 3.14159265358979323846;
    constexpr int kMostBits = 16;
    const double least_cosine = std::cos(tolerance_deg * kPi / 180);
    const auto serves = [&](const draco::OctahedronToolBox& box, const Vec3f& n) {
        const double stored[3] = {n.x * scale[0], n.y * scale[1], n.z * scale[2]};
        std::int32_t s = 0, t = 0;
        box.FloatVectorToQuantizedOctahedralCoords(stored, &s, &t);
        float back[3];
        box.QuantizedOctahedralCoordsToUnitVector(s, t, back);
        const double x = back[0] / scale[0], y = back[1] / scale[1], z = back[2] / scale[2];
        const double length =
            std::sqrt((x * x + y * y + z * z) * (double(n.x) * n.x + double(n.y) * n.y + double(n.z) * n.z));
        return x * n.x + y * n.y + z * n.z >= least_cosine * length;
    };
    int bits = 2;
    draco::OctahedronToolBox box;
    box.SetQuantizationBits(bits);
    for (std::size_t i = 0; i < normals.size() && bits < kMostBits;)
        if (serves(box, normals[i])) {
            ++i;
        } else {  // more bits may make an earlier normal a little worse, so all are checked again
            box.SetQuantizationBits(++bits);
            i = 0;
        }
    return bits;
}

DracoSummary summarise_draco(const std::vector<std::uint8_t>& bytes, const std::string& name) {
    std::string reason;
    bool is_mesh = false;
    const auto cloud = decode(reinterpret_cast<const char*>(bytes.data()), bytes.size(), reason, is_mesh);
    if (!cloud) throw Error(ErrorKind::input, "cannot read '" + name + "' as Draco: " + reason);
    DracoSummary out;
    out.vertices = cloud->num_points();
    out.triangles = is_mesh ? static_cast<const draco::Mesh&>(*cloud).num_faces() : 0;
    out.normals = unique_id(*cloud, GeometryAttribute::NORMAL) >= 0;
    out.texcoords = unique_id(*cloud, GeometryAttribute::TEX_COORD) >= 0;
    out.colors = unique_id(*cloud, GeometryAttribute::COLOR) >= 0;
    out.has_bounds = bounds(*cloud, out.min, out.max);
    return out;
}

std::vector<Vec3f> scaled_normals(const std::vector<Vec3f>& normals, const std::array<double, 3>& scale) {
    std::vector<Vec3f> out;
    out.reserve(normals.size());
    for (const Vec3f& n : normals) {
        const double x = n.x * scale[0], y = n.y * scale[1], z = n.z * scale[2];
        const double length = std::sqrt(x * x + y * y + z * z);
        out.push_back(
            {static_cast<float>(x / length), static_cast<float>(y / length), static_cast<float>(z / length)});
    }
    return out;
}

DracoPlan plan_draco(const TexturedMesh& textured, const Calibration* camera, const ExportConfig& config,
                     GridShape shape, int threads) {
    DracoPlan plan{textured.mesh, {}, {}};
    SurfaceMesh& mesh = plan.mesh;
    DracoQuantisation& quantisation = plan.quantisation;
    quantisation.level = config.draco.level;
    const bool is_on_grid = textured.grid_step_m > 0;
    if (config.draco.position_bits > 0 && !is_on_grid) {
        quantisation.position_bits = config.draco.position_bits;
    } else if (camera || is_on_grid) {
        Grid<3> grid = is_on_grid ? exact_grid(mesh.positions, textured.grid_step_m)
                                  : quantise_positions(mesh, *camera, config.tolerance_px, shape, threads);
        if (shape == GridShape::per_axis) {
            // Cells are counted from the camera: a translation would cost near vertices the last
            // bits of their floats.
            plan.transform.scale = grid.step;
            for (int axis = 0; axis < 3; ++axis) {
                grid.origin[axis] = std::round(grid.origin[axis] / grid.step[axis]);
                grid.step[axis] = 1;
            }
        }
        quantisation.positions = std::move(grid);
    }
    const auto& scale = plan.transform.scale;
    if (config.draco.normal_bits > 0)
        quantisation.normal_bits = config.draco.normal_bits;
    else
        quantisation.normal_bits = draco_normal_bits(mesh.normals, scale, config.tolerance_deg);
    if (scale[0] != scale[2]) mesh.normals = scaled_normals(mesh.normals, scale);
    if (config.draco.texcoord_bits > 0) {
        quantisation.texcoord_bits = config.draco.texcoord_bits;
    } else if (!mesh.texcoords.empty()) {
        quantisation.texcoords = quantise_texcoords(mesh.texcoords, textured.width_px, textured.height_px,
                                                    config.tolerance_px, GridShape::cubic);
    }
    // Six decimals hold integer cell numbers, but not small steps.
    quantisation.exact_boxes = (is_on_grid && shape == GridShape::cubic) ||
                               !keeps_tolerance(plan, textured, camera, config.tolerance_px);
    if (quantisation.exact_boxes && !keeps_tolerance(plan, textured, camera, config.tolerance_px))
        throw Error(ErrorKind::output,
                    "Draco's 32-bit numbers cannot hold this mesh within export.tolerance_px; raise it, or "
                    "write it without Draco");
    return plan;
}

CompressedMesh compress_draco(const TexturedMesh& textured, const Calibration* camera,
                              const ExportConfig& config, GridShape shape, int threads) {
    DracoPlan plan;
    const auto find = [&] {
        plan = plan_draco(textured, camera, config, shape, threads);
        return DracoValues{&plan.mesh, &plan.quantisation};
    };
    DracoMesh draco = encode_draco(textured.mesh, config.draco.level, find, threads);
    return {std::move(draco), plan.transform};
}

template <int N>
DracoBox box_of(const Grid<N>& grid, bool exactly) {
    DracoBox box{grid.bits(), {}, 0};
    std::copy(grid.origin.begin(), grid.origin.end(), box.origin.begin());
    box.range = static_cast<float>(grid.step[0] * ((1u << box.bits) - 1));
    if (exactly) return box;
    for (float& origin : box.origin) origin = in_six_decimals(origin);
    box.range = in_six_decimals(box.range);
    return box;
}
template DracoBox box_of(const Grid<2>&, bool);
template DracoBox box_of(const Grid<3>&, bool);

template <int N>
void set_box(draco::ExpertEncoder& encoder, int attribute, const Grid<N>& grid, bool exactly) {
    const DracoBox box = box_of(grid, true);
    encoder.SetAttributeExplicitQuantization(attribute, box.bits, N, box.origin.data(), box.range);
    if (!exactly) return;
    draco::Options options = *encoder.options().FindAttributeOptions(attribute);
    std::string origin;
    for (int axis = 0; axis < N; ++axis) origin += number_text(box.origin[axis]) + " ";
    options.SetString("quantization_origin", origin);
    options.SetString("quantization_range", number_text(box.range));
    encoder.options().SetAttributeOptions(attribute, options);
}
template void set_box(draco::ExpertEncoder&, int, const Grid<2>&, bool);
template void set_box(draco::ExpertEncoder&, int, const Grid<3>&, bool);

double position_error_px(const SurfaceMesh& mesh, const Calibration& camera, const Grid<3>& grid,
                         const FileTransform& transform, bool exactly) {
    const Decoded<3> decoded(grid, exactly);
    if (!decoded.is_box()) return INFINITY;
    double worst = 0;
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        const auto in_space = [&](int axis) { return decoded(i, axis) * transform.scale[axis]; };
        const Vec3f& p = mesh.positions[i];
        const double x = in_space(0), y = in_space(1), z = in_space(2);
        const double error =
            std::max({std::abs(x / z - double(p.x) / p.z), std::abs(y / z - double(p.y) / p.z),
                      camera.baseline_m * std::abs(1 / z - 1 / double(p.z))});
        if (!(error <= worst)) worst = error;
        if (std::isnan(worst)) break;
    }
    return worst * camera.focal_px;
}

double texcoord_error_px(const std::vector<Vec2f>& texcoords, int width, int height, const Grid<2>& grid,
                         bool exactly) {
    const Decoded<2> decoded(grid, exactly);
    if (!decoded.is_box()) return INFINITY;
    double worst = 0;
    for (std::size_t i = 0; i < texcoords.size(); ++i)
        worst = std::max({worst, std::abs(double(decoded(i, 0)) - texcoords[i].x) * width,
                          std::abs(double(decoded(i, 1)) - texcoords[i].y) * height});
    return worst;
}

}  // namespace hexrelief::exporters
