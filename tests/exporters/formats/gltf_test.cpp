#include <draco/compression/decode.h>

// As in exporters/formats/gltf/gltf_exporter.cpp: libdraco exports a tinygltf with another layout.
#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_ENABLE_DRACO
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define tinygltf tests_tinygltf
#include <tiny_gltf.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "tests/exporters/sample_scene.h"

namespace hexrelief::exporters {
namespace {

// Keeps the encoded bytes, the only part that these tests examine.
bool keep_image(tinygltf::Image* image, const int, std::string*, std::string*, int, int,
                const unsigned char* bytes, int size, void*) {
    image->image.assign(bytes, bytes + size);
    return true;
}

tinygltf::Model load(const std::filesystem::path& path) {
    tinygltf::TinyGLTF loader;
    loader.SetImageLoader(keep_image, nullptr);
    tinygltf::Model model;
    std::string error, warning;
    const bool loaded = path.extension() == ".glb"
                            ? loader.LoadBinaryFromFile(&model, &error, &warning, path.string())
                            : loader.LoadASCIIFromFile(&model, &error, &warning, path.string());
    EXPECT_TRUE(loaded) << error;
    EXPECT_EQ(error + warning, "");
    return model;
}

// Returns the accessor's bytes, which the exporter writes without a stride.
const unsigned char* bytes_of(const tinygltf::Model& model, const tinygltf::Accessor& accessor) {
    const tinygltf::BufferView& view = model.bufferViews.at(accessor.bufferView);
    EXPECT_EQ((view.byteOffset + accessor.byteOffset) % 4, 0u);
    return model.buffers.at(view.buffer).data.data() + view.byteOffset + accessor.byteOffset;
}

template <typename T>
std::vector<T> read(const tinygltf::Model& model, int index) {
    const tinygltf::Accessor& accessor = model.accessors.at(index);
    std::vector<T> out(accessor.count);
    std::memcpy(out.data(), bytes_of(model, accessor), out.size() * sizeof(T));
    return out;
}

nlohmann::json json_of(const std::filesystem::path& path) {
    const std::string bytes = contents(path);
    if (path.extension() == ".gltf") return nlohmann::json::parse(bytes);
    std::uint32_t size;
    std::memcpy(&size, bytes.data() + 12, 4);
    return nlohmann::json::parse(bytes.substr(20, size));
}

class Gltf : public ::testing::TestWithParam<const char*> {
  protected:
    tinygltf::Model exported(const SurfaceMesh& mesh, const Image* texture, const ExportConfig& config) {
        export_scene({&mesh, texture, kGenerator, extras_}, config, path_);
        return load(path_);
    }
    TemporaryFolder folder_;
    std::filesystem::path path_ = folder_ / GetParam();
    std::string extras_ = R"({"mesh":{"seed":18446744073709551615,"spacing_px":6.5,"list":[],"none":null}})";
};

TEST_P(Gltf, PlainMeshComesBackExactly) {
    const SurfaceMesh mesh = sample_mesh(24, 18);
    const Image texture = sample_texture(64, 48);
    const tinygltf::Model model = exported(mesh, &texture, {.normals = NormalsKind::always});
    ASSERT_EQ(model.meshes.size(), 1u);
    const tinygltf::Primitive& primitive = model.meshes[0].primitives.at(0);
    EXPECT_EQ(primitive.mode, TINYGLTF_MODE_TRIANGLES);
    EXPECT_EQ(read<Vec3f>(model, primitive.attributes.at("POSITION")), mesh.positions);
    EXPECT_EQ(read<Vec3f>(model, primitive.attributes.at("NORMAL")), mesh.normals);
    EXPECT_EQ(read<Vec2f>(model, primitive.attributes.at("TEXCOORD_0")), mesh.texcoords);
    EXPECT_EQ(model.accessors.at(primitive.indices).componentType, TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT);
    const auto indices = read<std::uint16_t>(model, primitive.indices);
    ASSERT_EQ(indices.size(), mesh.triangles.size() * 3);
    for (std::size_t i = 0; i < indices.size(); ++i) EXPECT_EQ(indices[i], mesh.triangles[i / 3][i % 3]);

    const tinygltf::Accessor& positions = model.accessors.at(primitive.attributes.at("POSITION"));
    for (int axis = 0; axis < 3; ++axis) {
        const auto value = [&](const Vec3f& p) { return axis == 0 ? p.x : axis == 1 ? p.y : p.z; };
        float low = INFINITY, high = -INFINITY;
        for (const Vec3f& p : mesh.positions) low = std::min(low, value(p)), high = std::max(high, value(p));
        EXPECT_EQ(positions.minValues.at(axis), static_cast<double>(low));
        EXPECT_EQ(positions.maxValues.at(axis), static_cast<double>(high));
    }
    for (const auto& [name, index] : primitive.attributes)
        EXPECT_EQ(model.bufferViews.at(model.accessors.at(index).bufferView).target,
                  TINYGLTF_TARGET_ARRAY_BUFFER);
    EXPECT_EQ(model.bufferViews.at(model.accessors.at(primitive.indices).bufferView).target,
              TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
}

// CesiumJS shows nothing of a mesh with an attribute that has no buffer view of its own, as sparse ones.
TEST_P(Gltf, ProvenanceIsADenseAttribute) {
    SurfaceMesh mesh = sample_mesh(24, 18);
    add_provenance(mesh);
    ExportConfig quantized;
    quantized.compression = Compression::quantized;
    for (const ExportConfig& config : {ExportConfig{}, quantized}) {
        const tinygltf::Model model = exported(mesh, nullptr, config);
        const tinygltf::Accessor& accessor =
            model.accessors.at(model.meshes.at(0).primitives.at(0).attributes.at("_PROVENANCE"));
        EXPECT_EQ(accessor.type, TINYGLTF_TYPE_SCALAR);
        EXPECT_EQ(accessor.componentType, TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE);
        EXPECT_FALSE(accessor.sparse.isSparse);
        ASSERT_EQ(accessor.count, mesh.positions.size());
        const tinygltf::BufferView& view = model.bufferViews.at(accessor.bufferView);
        ASSERT_EQ(view.byteStride % 4, 0u);
        ASSERT_EQ(accessor.byteOffset % 4, 0u);
        const std::size_t first = view.byteOffset + accessor.byteOffset;
        std::vector<Provenance> read;
        for (std::size_t i = 0; i < accessor.count; ++i)
            read.push_back(static_cast<Provenance>(model.buffers.at(0).data.at(first + view.byteStride * i)));
        EXPECT_EQ(read, mesh.provenance);
        EXPECT_EQ(accessor.extras.Get("nobody").Get<int>(),
                  std::count(read.begin(), read.end(), Provenance::nobody));
    }
}

TEST_P(Gltf, ProvenanceTakesNoBytesBesideTexcoords) {
    SurfaceMesh mesh = sample_mesh(24, 18);
    mesh.texcoords.back() = {1, 1};
    const Image texture = sample_texture(64, 48);
    const std::size_t before = exported(mesh, &texture, {}).buffers.at(0).data.size();
    add_provenance(mesh);
    const tinygltf::Model model = exported(mesh, &texture, {});
    EXPECT_EQ(model.buffers.at(0).data.size(), before);
    const auto texcoords =
        read<Vec2f>(model, model.meshes.at(0).primitives.at(0).attributes.at("TEXCOORD_0"));
    ASSERT_EQ(texcoords.size(), mesh.texcoords.size());
    for (std::size_t i = 0; i < texcoords.size(); ++i) {
        EXPECT_EQ(texcoords[i].x, mesh.texcoords[i].x);
        EXPECT_NEAR(texcoords[i].y, mesh.texcoords[i].y, 1. / (1 << 16));
        EXPECT_LE(texcoords[i].y, 1);
    }
}

// A vertex that the calibration projects to a pixel is at that pixel in the glTF camera's picture, too.
TEST_P(Gltf, CameraSeesWhatTheLeftCameraSaw) {
    const SurfaceMesh mesh = sample_mesh(8, 8);
    Calibration camera = sample_camera();
    camera.cx = 40;
    camera.cy = 20;
    Scene scene{&mesh, nullptr, kGenerator, extras_, &camera};
    export_scene(scene, {}, path_);
    EXPECT_TRUE(load(path_).cameras.empty());  // because the image's size is unknown
    camera.width = 64;
    camera.height = 48;
    export_scene(scene, {}, path_);
    const tinygltf::Model model = load(path_);
    ASSERT_EQ(model.cameras.size(), 1u);
    ASSERT_EQ(model.scenes.at(0).nodes, (std::vector<int>{0, 1}));
    const tinygltf::Node& node = model.nodes.at(1);
    EXPECT_EQ(node.camera, 0);
    EXPECT_TRUE(node.matrix.empty() && node.translation.empty() && node.rotation.empty());
    const tinygltf::PerspectiveCamera& seen = model.cameras[0].perspective;
    const tinygltf::Value& extras = model.cameras[0].extras;
    const double middle_x = extras.Get("principal_point_px").Get(0).GetNumberAsDouble(),
                 middle_y = extras.Get("principal_point_px").Get(1).GetNumberAsDouble();
    for (const Vec3f& p : mesh.positions) {
        const double half = std::tan(seen.yfov / 2) * -p.z;
        EXPECT_NEAR(middle_x + 32 * p.x / (half * seen.aspectRatio), camera.cx + 64 * p.x / -p.z, 1e-5);
        EXPECT_NEAR(middle_y - 24 * p.y / half, camera.cy - 64 * p.y / -p.z, 1e-5);
        EXPECT_LT(seen.znear, -p.z);
        EXPECT_GT(seen.zfar, -p.z);
    }
    EXPECT_EQ(extras.Get("focal_px").GetNumberAsDouble(), 64);
    EXPECT_EQ(extras.Get("size_px").Get(0).GetNumberAsInt(), 64);
    export_scene(scene, {.camera = false}, path_);
    EXPECT_TRUE(load(path_).cameras.empty());
}

TEST_P(Gltf, LooksLikeThePhotograph) {
    const SurfaceMesh mesh = sample_mesh(8, 8);
    const Image texture = sample_texture(64, 48);
    for (const TextureFormat format : {TextureFormat::jpeg, TextureFormat::png}) {
        const tinygltf::Model model = exported(mesh, &texture, {.texture = format});
        const tinygltf::Material& material = model.materials.at(0);
        EXPECT_TRUE(material.extensions.contains("KHR_materials_unlit"));
        EXPECT_EQ(model.extensionsUsed, std::vector<std::string>{"KHR_materials_unlit"});
        EXPECT_TRUE(model.extensionsRequired.empty());
        EXPECT_EQ(material.emissiveTexture.index, -1);
        EXPECT_EQ(material.pbrMetallicRoughness.baseColorFactor, (std::vector<double>{1, 1, 1, 1}));
        EXPECT_TRUE(material.doubleSided);
        EXPECT_EQ(material.pbrMetallicRoughness.metallicFactor, 0);
        EXPECT_EQ(material.pbrMetallicRoughness.roughnessFactor, 1);
        const tinygltf::Texture& reference =
            model.textures.at(material.pbrMetallicRoughness.baseColorTexture.index);
        const tinygltf::Sampler& sampler = model.samplers.at(reference.sampler);
        EXPECT_EQ(sampler.magFilter, TINYGLTF_TEXTURE_FILTER_LINEAR);
        EXPECT_EQ(sampler.minFilter, TINYGLTF_TEXTURE_FILTER_LINEAR_MIPMAP_LINEAR);
        EXPECT_EQ(sampler.wrapS, TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE);
        EXPECT_EQ(sampler.wrapT, TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE);
        const std::vector<unsigned char>& image = model.images.at(reference.source).image;
        ASSERT_GT(image.size(), 4u);
        EXPECT_EQ(image[1], format == TextureFormat::png ? 'P' : 0xd8);
    }
}

// A mesh that lights fall on has normals, unless the configuration says otherwise.
TEST_P(Gltf, MaterialDecidesAboutNormals) {
    const SurfaceMesh mesh = sample_mesh(8, 8);
    const Image texture = sample_texture(64, 48);
    const auto written = [&](MaterialKind material, NormalsKind normals) {
        const tinygltf::Model model = exported(mesh, &texture, {.normals = normals, .material = material});
        const bool is_unlit = material == MaterialKind::unlit;
        EXPECT_EQ(model.materials.at(0).extensions.contains("KHR_materials_unlit"), is_unlit);
        EXPECT_EQ(model.extensionsUsed.size(), is_unlit ? 1u : 0u);
        const bool is_emissive = material == MaterialKind::emissive;
        EXPECT_EQ(model.materials[0].emissiveTexture.index, is_emissive ? 0 : -1);
        EXPECT_EQ(model.materials[0].emissiveFactor, std::vector<double>(3, is_emissive ? 1 : 0));
        EXPECT_EQ(model.materials[0].pbrMetallicRoughness.baseColorFactor[0], is_emissive ? 0 : 1);
        return model.meshes.at(0).primitives.at(0).attributes.contains("NORMAL");
    };
    EXPECT_FALSE(written(MaterialKind::emissive, NormalsKind::automatic));
    EXPECT_FALSE(written(MaterialKind::unlit, NormalsKind::automatic));
    EXPECT_TRUE(written(MaterialKind::lit, NormalsKind::automatic));
    EXPECT_TRUE(written(MaterialKind::emissive, NormalsKind::always));
    EXPECT_FALSE(written(MaterialKind::lit, NormalsKind::never));
}

TEST_P(Gltf, WithoutTextureIsLitGrey) {
    const SurfaceMesh mesh = sample_mesh(8, 8);
    const tinygltf::Model model = exported(mesh, nullptr, {});
    EXPECT_TRUE(model.images.empty() && model.textures.empty() && model.samplers.empty());
    EXPECT_FALSE(model.meshes.at(0).primitives.at(0).attributes.contains("TEXCOORD_0"));
    EXPECT_TRUE(model.meshes[0].primitives[0].attributes.contains("NORMAL"));
    EXPECT_TRUE(model.materials.at(0).extensions.empty());
    EXPECT_TRUE(model.extensionsUsed.empty());
    const auto& colour = model.materials[0].pbrMetallicRoughness.baseColorFactor;
    EXPECT_EQ(colour[0], colour[1]);
    EXPECT_LT(colour[0], 1);
}

TEST_P(Gltf, NamesGeneratorAndParameters) {
    const SurfaceMesh mesh = sample_mesh(8, 8);
    const tinygltf::Model model = exported(mesh, nullptr, {});
    EXPECT_EQ(model.asset.version, "2.0");
    EXPECT_EQ(model.asset.generator, kGenerator);
    EXPECT_EQ(model.scenes.at(model.defaultScene).nodes, std::vector<int>{0});
    EXPECT_FALSE(model.nodes.at(0).name.empty());
    EXPECT_FALSE(model.meshes.at(0).name.empty());
    EXPECT_EQ(json_of(path_).at("asset").at("extras"), nlohmann::json::parse(extras_));
}

TEST_P(Gltf, IndicesGrowWithTheMesh) {
    for (const auto& [columns, rows, type] :
         {std::tuple{257, 254, TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT},  // 65278
          std::tuple{257, 255, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT},    // 65535
          std::tuple{300, 250, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT}}) {
        const SurfaceMesh mesh = sample_mesh(columns, rows);
        for (const bool draco : {false, true}) {
            ExportConfig config;
            if (draco) config.compression = Compression::draco;
            const tinygltf::Model model = exported(mesh, nullptr, config);
            const tinygltf::Primitive& primitive = model.meshes.at(0).primitives.at(0);
            EXPECT_EQ(model.accessors.at(primitive.indices).componentType, type);
            EXPECT_EQ(model.accessors.at(primitive.indices).count, mesh.triangles.size() * 3);
            if (draco || type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT) continue;
            const std::vector<std::uint32_t> indices = read<std::uint32_t>(model, primitive.indices);
            for (std::size_t i = 0; i < indices.size(); ++i)
                ASSERT_EQ(indices[i], mesh.triangles[i / 3][i % 3]);
        }
    }
}

TEST_P(Gltf, DracoViewDecodesToWhatTheAccessorsSay) {
    const SurfaceMesh mesh = sample_mesh(24, 18);
    const Image texture = sample_texture(64, 48);
    ExportConfig config{.compression = Compression::draco, .normals = NormalsKind::always};
    const tinygltf::Model model = exported(mesh, &texture, config);
    const std::vector<std::string> required = {"KHR_draco_mesh_compression"};
    EXPECT_EQ(model.extensionsRequired, required);
    EXPECT_EQ(std::count(model.extensionsUsed.begin(), model.extensionsUsed.end(), required[0]), 1);

    const tinygltf::Primitive& primitive = model.meshes.at(0).primitives.at(0);
    const tinygltf::Value& extension = primitive.extensions.at("KHR_draco_mesh_compression");
    const tinygltf::BufferView& view = model.bufferViews.at(extension.Get("bufferView").GetNumberAsInt());
    EXPECT_EQ(view.target, 0);
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(model.buffers.at(0).data.data()) + view.byteOffset,
                view.byteLength);
    draco::Decoder decoder;
    auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
    ASSERT_TRUE(decoded.ok());
    const draco::Mesh& back = *decoded.value();

    EXPECT_EQ(model.accessors.at(primitive.indices).count, back.num_faces() * 3);
    EXPECT_EQ(back.num_faces(), mesh.triangles.size());
    const std::map<std::string, draco::GeometryAttribute::Type> types = {
        {"POSITION", draco::GeometryAttribute::POSITION},
        {"NORMAL", draco::GeometryAttribute::NORMAL},
        {"TEXCOORD_0", draco::GeometryAttribute::TEX_COORD}};
    EXPECT_EQ(primitive.attributes.size(), types.size());
    for (const auto& [name, type] : types) {
        const int id = extension.Get("attributes").Get(name).GetNumberAsInt();
        ASSERT_NE(back.GetAttributeByUniqueId(static_cast<std::uint32_t>(id)), nullptr);
        EXPECT_EQ(back.GetAttributeByUniqueId(static_cast<std::uint32_t>(id))->attribute_type(), type);
        EXPECT_EQ(model.accessors.at(primitive.attributes.at(name)).count, back.num_points());
    }
    const nlohmann::json json = json_of(path_);
    EXPECT_EQ(json.at("accessors").size(), 4u);
    for (const auto& accessor : json.at("accessors")) EXPECT_FALSE(accessor.contains("bufferView"));

    // tinygltf has decoded the mesh itself by now.
    const tinygltf::Accessor& accessor = model.accessors.at(primitive.attributes.at("POSITION"));
    const std::vector<Vec3f> positions = read<Vec3f>(model, primitive.attributes.at("POSITION"));
    ASSERT_EQ(positions.size(), mesh.positions.size());
    Vec3f low = positions[0], high = low;
    for (const Vec3f& p : positions) {
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    EXPECT_EQ(accessor.minValues, (std::vector<double>{low.x, low.y, low.z}));
    EXPECT_EQ(accessor.maxValues, (std::vector<double>{high.x, high.y, high.z}));
    const auto indices = read<std::uint16_t>(model, primitive.indices);
    for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {  // all triangles face the camera
        const Vec3f &a = positions.at(indices[i]), &b = positions.at(indices[i + 1]),
                    &c = positions.at(indices[i + 2]);
        EXPECT_GT((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x), 0);
    }
}

constexpr const char* kContainerNames[] = {"Glb", "Split", "Encoded"};

INSTANTIATE_TEST_SUITE_P(Containers, Gltf,
                         ::testing::Values("relief.glb", "relief.gltf", "two words 100%.gltf"),
                         [](const auto& instance) { return kContainerNames[instance.index]; });

TEST(GltfDocument, DracoGlbIsMuchSmaller) {
    const TemporaryFolder folder;
    const SurfaceMesh mesh = sample_mesh(75, 62);
    ExportConfig config;
    export_scene({&mesh, nullptr, kGenerator, ""}, config, folder / "plain.glb");
    config.compression = Compression::draco;
    export_scene({&mesh, nullptr, kGenerator, ""}, config, folder / "draco.glb");
    EXPECT_LT(std::filesystem::file_size(folder / "draco.glb") * 8,
              std::filesystem::file_size(folder / "plain.glb"));
}

TEST(GltfDocument, BytesThatAreNoUtf8DoNotBreakTheJson) {
    const TemporaryFolder folder;
    const SurfaceMesh mesh = sample_mesh(4, 4);
    export_scene({&mesh, nullptr, kGenerator, ""}, {}, folder / "caf\xe9.gltf");
    const auto json = nlohmann::json::parse(contents(folder / "caf\xe9.gltf"));
    EXPECT_EQ(json["buffers"][0]["uri"], "caf%E9.bin");
}

}  // namespace
}  // namespace hexrelief::exporters
