#include "exporters/compression/draco_codec.h"

#include <draco/compression/attributes/normal_compression_utils.h>
#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <new>
#include <stdexcept>

#include "pipeline/data/error.h"

namespace hexrelief {
namespace {

using draco::GeometryAttribute;

// Adds one value a vertex, point i = vertex i, and returns the attribute's index.
template <typename T>
int add_attribute(draco::Mesh& mesh, GeometryAttribute::Type type, const std::vector<T>& values) {
    constexpr int components = sizeof(T) / sizeof(float);
    GeometryAttribute attribute;
    attribute.Init(type, nullptr, components, draco::DT_FLOAT32, false, sizeof(T), 0);
    const int index =
        mesh.AddAttribute(attribute, true, static_cast<draco::AttributeValueIndex::ValueType>(values.size()));
    mesh.attribute(index)->buffer()->Write(0, values.data(), values.size() * sizeof(T));
    return index;
}

// The grid's values as floats, from which Draco finds the cells again.
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

void fill(draco::Mesh& out, const SurfaceMesh& mesh, const DracoQuantisation& quantisation) {
    out.set_num_points(static_cast<std::uint32_t>(mesh.positions.size()));
    out.SetNumFaces(mesh.triangles.size());
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const Triangle& t = mesh.triangles[i];
        out.SetFace(draco::FaceIndex(static_cast<std::uint32_t>(i)),
                    {draco::PointIndex(t[0]), draco::PointIndex(t[1]), draco::PointIndex(t[2])});
    }
    add_attribute(out, GeometryAttribute::POSITION,
                  quantisation.positions ? values_of<Vec3f>(*quantisation.positions) : mesh.positions);
    if (!mesh.normals.empty()) add_attribute(out, GeometryAttribute::NORMAL, mesh.normals);
    if (!mesh.texcoords.empty())
        add_attribute(out, GeometryAttribute::TEX_COORD,
                      quantisation.texcoords ? values_of<Vec2f>(*quantisation.texcoords) : mesh.texcoords);
}

int unique_id(const draco::PointCloud& cloud, GeometryAttribute::Type type) {
    const draco::PointAttribute* attribute = cloud.GetNamedAttribute(type);
    return attribute ? static_cast<int>(attribute->unique_id()) : -1;
}

// False where there is no position.
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

}  // namespace

namespace {

constexpr int kDracosChoice = -1000;

struct Predictions {
    int normals = kDracosChoice, texcoords = kDracosChoice;
};

std::vector<std::uint8_t> encode(const draco::Mesh& input, const DracoQuantisation& quantisation,
                                 const Predictions& predictions) {
    draco::ExpertEncoder encoder(input);
    encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
    encoder.SetSpeedOptions(10 - quantisation.level, 10 - quantisation.level);
    const auto quantise = [&](GeometryAttribute::Type type, int bits, const auto& grid, int prediction) {
        const int index = input.GetNamedAttributeId(type);
        if (index < 0) return;
        if (prediction != kDracosChoice) encoder.SetAttributePredictionScheme(index, prediction);
        if (!grid) {
            encoder.SetAttributeQuantization(index, bits);
            return;
        }
        std::array<float, 3> origin = {};
        std::copy(grid->origin.begin(), grid->origin.end(), origin.begin());
        const int grid_bits = grid->bits();
        const double range = grid->step[0] * ((1u << grid_bits) - 1);
        encoder.SetAttributeExplicitQuantization(index, grid_bits, static_cast<int>(grid->origin.size()),
                                                 origin.data(), static_cast<float>(range));
    };
    quantise(GeometryAttribute::POSITION, quantisation.position_bits, quantisation.positions, kDracosChoice);
    quantise(GeometryAttribute::NORMAL, quantisation.normal_bits, std::optional<Grid<2>>(),
             predictions.normals);
    quantise(GeometryAttribute::TEX_COORD, quantisation.texcoord_bits, quantisation.texcoords,
             predictions.texcoords);
    draco::EncoderBuffer buffer;
    const draco::Status status = encoder.EncodeToBuffer(&buffer);
    if (!status.ok()) {
        throw Error(ErrorKind::output, "cannot compress the mesh with Draco: " + status.error_msg_string());
    }
    return {buffer.data(), buffer.data() + buffer.size()};
}

// At the highest level the predictions that Draco would not choose are tried as well: they save up to 13 %
// where surfaces are planes (venus), nothing on others.
std::vector<std::uint8_t> smallest(const draco::Mesh& input, const DracoQuantisation& quantisation) {
    Predictions predictions;
    std::vector<std::uint8_t> best = encode(input, quantisation, predictions);
    if (quantisation.level < 10) return best;
    const auto attempt = [&](GeometryAttribute::Type type, int Predictions::*member, int prediction) {
        if (input.GetNamedAttributeId(type) < 0) return;
        Predictions other = predictions;
        other.*member = prediction;
        std::vector<std::uint8_t> bytes = encode(input, quantisation, other);
        if (bytes.size() >= best.size()) return;
        best = std::move(bytes);
        predictions = other;
    };
    attempt(GeometryAttribute::NORMAL, &Predictions::normals, draco::PREDICTION_DIFFERENCE);
    attempt(GeometryAttribute::TEX_COORD, &Predictions::texcoords, draco::MESH_PREDICTION_PARALLELOGRAM);
    attempt(GeometryAttribute::TEX_COORD, &Predictions::texcoords,
            draco::MESH_PREDICTION_CONSTRAINED_MULTI_PARALLELOGRAM);
    return best;
}

}  // namespace

DracoMesh encode_draco(const SurfaceMesh& mesh, const DracoQuantisation& quantisation) {
    draco::Mesh input;  // can be neither copied nor moved
    fill(input, mesh, quantisation);
    std::vector<std::uint8_t> bytes = smallest(input, quantisation);

    // Decoded once, because dequantised positions can lie a little outside the box of the given ones, and
    // glTF's accessors must bound what a viewer gets; costs a third of the encoding.
    std::string reason;
    bool is_mesh = false;
    const std::unique_ptr<draco::PointCloud> decoded =
        decode(reinterpret_cast<const char*>(bytes.data()), bytes.size(), reason, is_mesh);
    DracoMesh out;
    if (!decoded || !is_mesh || !bounds(*decoded, out.min, out.max)) {
        throw Error(ErrorKind::output, "cannot read back the mesh compressed with Draco: " + reason);
    }
    out.vertices = decoded->num_points();
    out.triangles = static_cast<const draco::Mesh&>(*decoded).num_faces();
    out.position_id = unique_id(*decoded, GeometryAttribute::POSITION);
    out.normal_id = unique_id(*decoded, GeometryAttribute::NORMAL);
    out.texcoord_id = unique_id(*decoded, GeometryAttribute::TEX_COORD);
    out.bytes = std::move(bytes);
    return out;
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
    for (std::size_t i = 0; i < normals.size() && bits < kMostBits;) {
        if (serves(box, normals[i])) {
            ++i;
        } else {  // more bits may make an earlier normal a little worse, so all are measured again
            box.SetQuantizationBits(++bits);
            i = 0;
        }
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

}  // namespace hexrelief
