#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>

#include <cstdlib>

#include "exporters/compression/draco_codec.h"
#include "tests/exporters/draco_decode.h"
#include "tests/exporters/sample_scene.h"

namespace hexrelief::exporters {
namespace {

std::unique_ptr<draco::Mesh> decode(const std::string& bytes) {
    draco::DecoderBuffer buffer;
    buffer.Init(bytes.data(), bytes.size());
    draco::Decoder decoder;
    auto mesh = decoder.DecodeMeshFromBuffer(&buffer);
    EXPECT_TRUE(mesh.ok()) << mesh.status().error_msg_string();
    return std::move(mesh).value();
}

template <int N>
std::vector<std::array<float, N>> values(const draco::Mesh& mesh, draco::GeometryAttribute::Type type) {
    const draco::PointAttribute* attribute = mesh.GetNamedAttribute(type);
    EXPECT_NE(attribute, nullptr);
    std::vector<std::array<float, N>> out(mesh.num_points());
    for (std::uint32_t i = 0; i < mesh.num_points(); ++i)
        attribute->ConvertValue<float, N>(attribute->mapped_index(draco::PointIndex(i)), out[i].data());
    return out;
}

// Returns for each decoded vertex the index of the nearest given one.
std::vector<std::size_t> nearest(const std::vector<std::array<float, 3>>& found,
                                 const std::vector<Vec3f>& given) {
    std::vector<std::size_t> out;
    for (const auto& p : found) {
        std::size_t best = 0;
        float best_distance = INFINITY;
        for (std::size_t i = 0; i < given.size(); ++i) {
            const float d = std::hypot(p[0] - given[i].x, p[1] - given[i].y, p[2] - given[i].z);
            if (d < best_distance) best = i, best_distance = d;
        }
        out.push_back(best);
    }
    return out;
}

void fill_for_draco(const SurfaceMesh& mesh, draco::Mesh& out) {
    const auto add = [&](draco::GeometryAttribute::Type type, const auto& values) {
        constexpr int kComponents = sizeof(values[0]) / sizeof(float);
        draco::GeometryAttribute attribute;
        attribute.Init(type, nullptr, kComponents, draco::DT_FLOAT32, false, sizeof(values[0]), 0);
        const int index = out.AddAttribute(attribute, true, static_cast<std::uint32_t>(values.size()));
        out.attribute(index)->buffer()->Write(0, values.data(), values.size() * sizeof(values[0]));
    };
    out.set_num_points(static_cast<std::uint32_t>(mesh.positions.size()));
    for (const Triangle& t : mesh.triangles)
        out.AddFace({draco::PointIndex(t[0]), draco::PointIndex(t[1]), draco::PointIndex(t[2])});
    add(draco::GeometryAttribute::POSITION, mesh.positions);
    add(draco::GeometryAttribute::NORMAL, mesh.normals);
    add(draco::GeometryAttribute::TEX_COORD, mesh.texcoords);
}

class DracoBits : public ::testing::TestWithParam<int> {};  // the parameter is the level

TEST_P(DracoBits, DrcHoldsTheMeshWithinQuantisation) {
    const TemporaryFolder folder;
    const SurfaceMesh mesh = sample_mesh(24, 18);
    const Image texture = sample_texture(16, 16);
    export_scene({&mesh, &texture, kGenerator, ""}, {.draco = {12, 8, 12, GetParam()}}, folder / "a.drc");
    const auto back = decode(contents(folder / "a.drc"));
    EXPECT_EQ(back->num_points(), mesh.positions.size());
    EXPECT_EQ(back->num_faces(), mesh.triangles.size());

    const auto positions = values<3>(*back, draco::GeometryAttribute::POSITION);
    const auto normals = values<3>(*back, draco::GeometryAttribute::NORMAL);
    const auto texcoords = values<2>(*back, draco::GeometryAttribute::TEX_COORD);
    const float step = 2.f / 4095;  // the widest side over 12 bits
    std::vector<std::size_t> source = nearest(positions, mesh.positions);
    for (std::size_t i = 0; i < source.size(); ++i) {
        const Vec3f& p = mesh.positions[source[i]];
        EXPECT_NEAR(positions[i][0], p.x, 0.51f * step);
        EXPECT_NEAR(positions[i][1], p.y, 0.51f * step);
        EXPECT_NEAR(positions[i][2], p.z, 0.51f * step);
        EXPECT_NEAR(texcoords[i][0], mesh.texcoords[source[i]].x, 0.51f / 4095);
        // The origin stays at the top left.
        EXPECT_NEAR(texcoords[i][1], mesh.texcoords[source[i]].y, 0.51f / 4095);
        const Vec3f& n = mesh.normals[source[i]];
        EXPECT_GT(normals[i][0] * n.x + normals[i][1] * n.y + normals[i][2] * n.z, 0.999f);
    }
    for (std::uint32_t f = 0; f < back->num_faces(); ++f) {  // winding: all triangles face the camera
        const auto& face = back->face(draco::FaceIndex(f));
        const auto &a = positions[face[0].value()], &b = positions[face[1].value()],
                   &c = positions[face[2].value()];
        EXPECT_GT((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]), 0);
    }
    std::sort(source.begin(), source.end());
    EXPECT_EQ(std::unique(source.begin(), source.end()), source.end());  // a one-to-one mapping
}

INSTANTIATE_TEST_SUITE_P(Levels, DracoBits, ::testing::Values(0, 3, 7, 10));

TEST(Draco, BoundsAreThoseOfTheDecodedPositions) {
    const SurfaceMesh mesh = sample_mesh(24, 18);
    for (const int bits : {3, 8, 12, 17}) {
        DracoQuantisation config;
        config.position_bits = bits;
        const DracoMesh encoded = encode_draco(mesh, config);
        const auto back = decode({encoded.bytes.begin(), encoded.bytes.end()});
        Vec3f low{INFINITY, INFINITY, INFINITY}, high{-INFINITY, -INFINITY, -INFINITY};
        for (const auto& p : values<3>(*back, draco::GeometryAttribute::POSITION)) {
            low = {std::min(low.x, p[0]), std::min(low.y, p[1]), std::min(low.z, p[2])};
            high = {std::max(high.x, p[0]), std::max(high.y, p[1]), std::max(high.z, p[2])};
        }
        EXPECT_EQ(encoded.min, low);
        EXPECT_EQ(encoded.max, high);
        EXPECT_EQ(encoded.vertices, back->num_points());
        EXPECT_EQ(encoded.triangles, back->num_faces());
    }
}

// Encodes by Draco's own interface, with the given predictions; a prediction of -1000 leaves
// the choice to Draco.
std::size_t bytes_by_expert_encoder(const draco::Mesh& mesh, const DracoQuantisation& quantisation,
                                    int normals, int texcoords) {
    draco::ExpertEncoder encoder(mesh);
    encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
    encoder.SetSpeedOptions(0, 0);
    for (int i = 0; i < mesh.num_attributes(); ++i) {
        const auto type = mesh.attribute(i)->attribute_type();
        encoder.SetAttributeQuantization(
            i, type == draco::GeometryAttribute::POSITION ? quantisation.position_bits
               : type == draco::GeometryAttribute::NORMAL ? quantisation.normal_bits
                                                          : quantisation.texcoord_bits);
        const int prediction = type == draco::GeometryAttribute::NORMAL      ? normals
                               : type == draco::GeometryAttribute::TEX_COORD ? texcoords
                                                                             : -1000;
        if (prediction != -1000) encoder.SetAttributePredictionScheme(i, prediction);
    }
    draco::EncoderBuffer buffer;
    EXPECT_TRUE(encoder.EncodeToBuffer(&buffer).ok());
    return buffer.size();
}

TEST(Draco, TakesTheSmallestOfAllPredictionsWithAnyNumberOfThreads) {
    for (const float flatness : {0.0f, 1.0f}) {
        SurfaceMesh mesh = sample_mesh(40, 30);
        if (flatness > 0)
            for (Vec3f& n : mesh.normals) n = {0, 0, 1};
        const DracoQuantisation quantisation;
        draco::Mesh input;
        fill_for_draco(mesh, input);
        std::size_t least = SIZE_MAX;
        for (const int normals : {-1000, int{draco::PREDICTION_DIFFERENCE}})
            for (const int texcoords : {-1000, int{draco::MESH_PREDICTION_PARALLELOGRAM},
                                        int{draco::MESH_PREDICTION_CONSTRAINED_MULTI_PARALLELOGRAM}})
                least = std::min(least, bytes_by_expert_encoder(input, quantisation, normals, texcoords));
        const DracoMesh encoded = encode_draco(mesh, quantisation, 1);
        EXPECT_EQ(encoded.bytes.size(), least);
        for (const int threads : {2, 4, 5})
            EXPECT_EQ(encoded.bytes, encode_draco(mesh, quantisation, threads).bytes) << threads;
    }
}

TEST(Draco, FewerBitsAndHigherLevelsGiveFewerBytes) {
    const SurfaceMesh mesh = sample_mesh(60, 50);
    const auto bytes = [&](int bits, int level) {
        DracoQuantisation config;
        config.position_bits = bits;
        config.level = level;
        return encode_draco(mesh, config).bytes.size();
    };
    EXPECT_LT(bytes(8, 7), bytes(12, 7));
    EXPECT_LT(bytes(12, 7), bytes(16, 7));
    EXPECT_LT(bytes(12, 10), bytes(12, 0));
}

TEST(Draco, AttributesThatAreMissingStayMissing) {
    SurfaceMesh mesh = sample_mesh(5, 5);
    mesh.normals.clear();
    mesh.texcoords.clear();
    const DracoMesh encoded = encode_draco(mesh, {});
    EXPECT_GE(encoded.position_id, 0);
    EXPECT_EQ(encoded.normal_id, -1);
    EXPECT_EQ(encoded.texcoord_id, -1);
}

// The mesh has two surfaces that touch in one vertex, an unused vertex and a triangle without area.
TEST(Draco, UnevenMeshesAreCountedAsDecoded) {
    SurfaceMesh mesh;
    mesh.positions = {{0, 0, -1}, {1, 0, -1}, {0, 1, -1}, {-1, 0, -1}, {0, -1, -1}, {5, 5, -5}};
    mesh.normals.assign(6, {0, 0, 1});
    mesh.texcoords.assign(6, {0, 0});
    mesh.triangles = {{0, 1, 2}, {0, 3, 4}, {1, 1, 2}};
    const DracoMesh encoded = encode_draco(mesh, {});
    const auto back = decode({encoded.bytes.begin(), encoded.bytes.end()});
    EXPECT_EQ(encoded.vertices, back->num_points());
    EXPECT_EQ(encoded.triangles, back->num_faces());
    EXPECT_GE(encoded.triangles, 2);
}

TEST(Draco, SingleTriangleAndFlatMesh) {
    SurfaceMesh mesh;
    mesh.positions = {{0, 0, -1}, {1, 0, -1}, {0, 1, -1}};
    mesh.normals.assign(3, {0, 0, 1});
    mesh.texcoords = {{0, 1}, {1, 1}, {0, 0}};
    mesh.triangles = {{0, 1, 2}};
    const DracoMesh encoded = encode_draco(mesh, {});
    EXPECT_EQ(encoded.vertices, 3);
    EXPECT_EQ(encoded.triangles, 1);
}

TEST(Draco, DecoderProgramReadsDrc) {
    if (std::system("command -v draco_decoder >/dev/null") != 0)
        GTEST_SKIP() << "draco_decoder is not there; install the package draco";
    const TemporaryFolder folder;
    const SurfaceMesh mesh = sample_mesh(24, 18);
    const Image texture = sample_texture(16, 16);
    export_scene({&mesh, &texture, kGenerator, ""}, {}, folder / "a.drc");
    const std::string command = "draco_decoder -i '" + (folder / "a.drc").string() + "' -o '" +
                                (folder / "a.obj").string() + "' >/dev/null";
    ASSERT_EQ(std::system(command.c_str()), 0);
    std::ifstream stream(folder / "a.obj");
    std::size_t vertices = 0, faces = 0;
    for (std::string line; std::getline(stream, line);) {
        vertices += line.starts_with("v ");
        faces += line.starts_with("f ");
    }
    EXPECT_EQ(vertices, mesh.positions.size());
    EXPECT_EQ(faces, mesh.triangles.size());
}

}  // namespace
}  // namespace hexrelief::exporters
