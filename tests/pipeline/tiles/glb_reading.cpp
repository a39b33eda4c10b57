#include "tests/pipeline/tiles/glb_reading.h"

#include <draco/compression/decode.h>
#include <meshoptimizer.h>

#include <cstdint>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace hexrelief::tiles {
namespace {

using Json = nlohmann::json;

void require(bool condition, const char* what) {
    if (!condition) throw std::runtime_error(what);
}

class Glb {
  public:
    explicit Glb(const std::filesystem::path& path) {
        std::ifstream file(path, std::ios::binary);
        const std::vector<char> bytes((std::istreambuf_iterator<char>(file)), {});
        require(bytes.size() > 28 && std::memcmp(bytes.data(), "glTF", 4) == 0, "no GLB");
        std::uint32_t length = 0;
        std::memcpy(&length, &bytes[12], 4);
        json = Json::parse(bytes.begin() + 20, bytes.begin() + 20 + length);
        data_.assign(bytes.begin() + 20 + length + 8, bytes.end());
    }
    Json json;

    SpaceMesh mesh_of(const Json& primitive) const {
        if (primitive.contains("extensions")) return decoded_draco(primitive);
        SpaceMesh mesh;
        const Json& positions = json["accessors"][primitive["attributes"]["POSITION"].get<std::size_t>()];
        const bool is_float = positions["componentType"] == 5126,
                   is_short = positions["componentType"] == 5123;
        const std::size_t size = is_float ? 4 : is_short ? 2 : 1;
        const auto [bytes, stride] = view(positions["bufferView"], size * 3);
        for (std::size_t i = 0; i < positions["count"].get<std::size_t>(); ++i) {
            std::array<double, 3>& p = mesh.positions.emplace_back();
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint8_t* at = bytes.data() + i * stride + k * size;
                float real = 0;
                std::uint16_t wide = 0;
                if (is_float) std::memcpy(&real, at, 4);
                if (is_short) std::memcpy(&wide, at, 2);
                p[k] = is_float ? double(real) : is_short ? wide : *at;
            }
        }
        const Json& indices = json["accessors"][primitive["indices"].get<std::size_t>()];
        const bool narrow = indices["componentType"] == 5123;
        const auto [numbers, step] = view(indices["bufferView"], narrow ? 2 : 4);
        for (std::size_t i = 0; i < indices["count"].get<std::size_t>(); ++i) {
            std::uint32_t v = 0;
            std::memcpy(&v, numbers.data() + i * step, narrow ? 2 : 4);
            if (i % 3 == 0) mesh.triangles.emplace_back();
            mesh.triangles.back()[i % 3] = v;
        }
        return mesh;
    }

  private:
    std::pair<std::vector<std::uint8_t>, std::size_t> view(const Json& index, std::size_t item) const {
        const Json& view = json["bufferViews"][index.get<std::size_t>()];
        if (!view.contains("extensions")) {
            const auto* const first = data_.data() + view.value("byteOffset", 0);
            return {{first, first + view["byteLength"].get<std::size_t>()}, view.value("byteStride", item)};
        }
        const Json& packed = view["extensions"]["EXT_meshopt_compression"];
        const std::size_t count = packed["count"], stride = packed["byteStride"];
        const std::uint8_t* const first = data_.data() + packed["byteOffset"].get<std::size_t>();
        const std::size_t bytes = packed["byteLength"];
        std::vector<std::uint8_t> out(count * stride);
        require((packed["mode"] == "TRIANGLES"
                     ? meshopt_decodeIndexBuffer(out.data(), count, stride, first, bytes)
                     : meshopt_decodeVertexBuffer(out.data(), count, stride, first, bytes)) == 0,
                "meshopt refuses it");
        return {out, stride};
    }
    SpaceMesh decoded_draco(const Json& primitive) const {
        const Json& packed = primitive["extensions"]["KHR_draco_mesh_compression"];
        const Json& view = json["bufferViews"][packed["bufferView"].get<std::size_t>()];
        draco::DecoderBuffer buffer;
        buffer.Init(reinterpret_cast<const char*>(data_.data()) + view.value("byteOffset", 0),
                    view["byteLength"].get<std::size_t>());
        auto decoded = draco::Decoder().DecodeMeshFromBuffer(&buffer);
        require(decoded.ok(), "draco refuses it");
        const draco::Mesh& from = *decoded.value();
        const draco::PointAttribute* const at =
            from.GetAttributeByUniqueId(packed["attributes"]["POSITION"].get<std::uint32_t>());
        SpaceMesh mesh;
        for (draco::PointIndex i(0); i < from.num_points(); ++i) {
            float p[3];
            at->GetMappedValue(i, p);
            mesh.positions.push_back({p[0], p[1], p[2]});
        }
        for (draco::FaceIndex f(0); f < from.num_faces(); ++f)
            mesh.triangles.push_back(
                {from.face(f)[0].value(), from.face(f)[1].value(), from.face(f)[2].value()});
        return mesh;
    }
    std::vector<std::uint8_t> data_;
};

}  // namespace

SpaceMesh read_glb(const std::filesystem::path& path) {
    const Glb glb(path);
    SpaceMesh all;
    for (const Json& number : glb.json["scenes"][0]["nodes"]) {
        const Json& node = glb.json["nodes"][number.get<std::size_t>()];
        SpaceMesh mesh = glb.mesh_of(glb.json["meshes"][node["mesh"].get<std::size_t>()]["primitives"][0]);
        const auto moved = node.value("translation", std::array<double, 3>{0, 0, 0}),
                   scale = node.value("scale", std::array<double, 3>{1, 1, 1});
        const auto first = static_cast<std::uint32_t>(all.positions.size());
        for (const auto& p : mesh.positions)
            all.positions.push_back(
                {moved[0] + scale[0] * p[0], moved[1] + scale[1] * p[1], moved[2] + scale[2] * p[2]});
        for (const Triangle& t : mesh.triangles)
            all.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    }
    return all;
}

}  // namespace hexrelief::tiles
