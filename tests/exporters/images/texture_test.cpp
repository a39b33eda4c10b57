// Tests which part of the picture goes into the file, and its size.
#include "exporters/images/texture.h"

#include <webp/decode.h>

#include "exporters/images/image_writer.h"
#include "pipeline/data/error.h"
#include "tests/exporters/sample_scene.h"

namespace hexrelief::exporters {
namespace {

SurfaceMesh part_of_the_picture() {
    SurfaceMesh mesh = sample_mesh(8, 6);
    for (Vec2f& t : mesh.texcoords) t = {0.25f + t.x / 4, 0.5f + t.y / 4};
    return mesh;
}

TEST(Texture, IsCroppedToWhatTheMeshShows) {
    const SurfaceMesh mesh = part_of_the_picture();
    const Image image = sample_texture(64, 48);
    const TexturedMesh out = textured_mesh({&mesh, &image, "", ""}, {});
    const Image texture = texture_of(image, out);
    // The part is x 16 .. 32 px and y 24 .. 36 px, with a margin of two px.
    ASSERT_EQ(texture.width, 20);
    ASSERT_EQ(texture.height, 16);
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 20; ++x)
            for (int c = 0; c < 3; ++c) ASSERT_EQ(texture.at(x, y)[c], image.at(x + 14, y + 22)[c]);
    for (std::size_t i = 0; i < mesh.texcoords.size(); ++i) {
        EXPECT_NEAR(out.mesh.texcoords[i].x * 20, mesh.texcoords[i].x * 64 - 14, 1e-4);
        EXPECT_NEAR(out.mesh.texcoords[i].y * 16, mesh.texcoords[i].y * 48 - 22, 1e-4);
    }
}

TEST(Texture, StaysWholeWhereAsked) {
    const SurfaceMesh mesh = part_of_the_picture();
    const Image image = sample_texture(64, 48);
    const TexturedMesh out = textured_mesh({&mesh, &image, "", ""}, {.texture_crop = false});
    EXPECT_EQ(texture_of(image, out).pixels, image.pixels);
    EXPECT_EQ(out.mesh.texcoords, mesh.texcoords);
}

TEST(Texture, LevelsOfDetailShareOneCrop) {
    const SurfaceMesh mesh = part_of_the_picture(), whole = sample_mesh(4, 3);
    const Image image = sample_texture(64, 48);
    const auto levels = textured_levels({&mesh, &image, "", "", nullptr, {&whole}}, {});
    ASSERT_EQ(levels.size(), 2u);
    EXPECT_EQ(levels[0].mesh.texcoords, mesh.texcoords);
    for (const TexturedMesh& level : levels) {
        EXPECT_TRUE(level.textured);
        EXPECT_EQ(level.width_px, 64);
        EXPECT_EQ(level.part.width, 64);
    }
}

TEST(Texture, SizeCapAveragesAreas) {
    const SurfaceMesh mesh = sample_mesh(4, 4);
    Image image{9, 6, 1, {}};
    for (int i = 0; i < 54; ++i) image.pixels.push_back(static_cast<std::uint8_t>(4 * i));
    ExportConfig config{.texture_max_px = 3};
    const auto texture = [&] { return texture_of(image, textured_mesh({&mesh, &image, "", ""}, config)); };
    const Image out = texture();
    ASSERT_EQ(out.width, 3);
    ASSERT_EQ(out.height, 2);
    for (int y = 0; y < 2; ++y)
        for (int x = 0; x < 3; ++x) {
            int sum = 0;
            for (int k = 0; k < 9; ++k) sum += *image.at(3 * x + k % 3, 3 * y + k / 3);
            EXPECT_NEAR(*out.at(x, y), sum / 9.0, 0.51);
        }
    config.texture_max_px = 4;  // pixels are shared between two, but the mean is unchanged
    const Image shared = texture();
    EXPECT_EQ(shared.width, 4);
    EXPECT_EQ(shared.height, 3);
    double before = 0, after = 0;
    for (const std::uint8_t v : image.pixels) before += v / 54.0;
    for (const std::uint8_t v : shared.pixels) after += v / 12.0;
    EXPECT_NEAR(before, after, 0.5);
    config.texture_max_px = 9;
    EXPECT_EQ(texture().pixels, image.pixels);
}

TEST(Texture, AttributesAreOptional) {
    const SurfaceMesh mesh = sample_mesh(4, 4);
    const Image image = sample_texture(16, 16);
    const Scene scene{&mesh, &image, "", ""};
    ExportConfig config{.normals = NormalsKind::never, .texture = TextureFormat::none};
    TexturedMesh out = textured_mesh(scene, config);
    EXPECT_TRUE(out.mesh.normals.empty() && !out.textured);
    EXPECT_EQ(out.mesh.texcoords, mesh.texcoords);
    config.texcoords = false;
    config.texture = TextureFormat::jpeg;
    out = textured_mesh(scene, config);
    EXPECT_TRUE(out.mesh.texcoords.empty() && !out.textured);
}

class WebpQuality : public ::testing::TestWithParam<int> {};  // the parameter is the number of channels

TEST_P(WebpQuality, ComesBackNearlyAsItWas) {
    const Image image = sample_texture(64, 48, GetParam());
    const auto low = encode_webp(image, 10), high = encode_webp(image, 100);
    EXPECT_LT(low.size(), high.size());
    int width = 0, height = 0;
    std::uint8_t* rgb = WebPDecodeRGB(high.data(), high.size(), &width, &height);
    ASSERT_NE(rgb, nullptr);
    EXPECT_EQ(width, 64);
    EXPECT_EQ(height, 48);
    double sum = 0;
    for (int i = 0; i < 64 * 48 * 3; ++i)
        sum += std::abs(rgb[i] - image.pixels[GetParam() == 3 ? i : i / 3]) / (64.0 * 48 * 3);
    EXPECT_LT(sum, 8);  // chroma is halved, and the checkerboard is blue
    WebPFree(rgb);
}

INSTANTIATE_TEST_SUITE_P(Channels, WebpQuality, ::testing::Values(1, 3));

TEST(Webp, RefusesWhatTheFormatCannotHold) {
    const Image wide{16384, 1, 1, std::vector<std::uint8_t>(16384)};
    EXPECT_CONTAINS(test::error_of([&] { encode_webp(wide, 90); }, ErrorKind::output), "16383");
}

}  // namespace
}  // namespace hexrelief::exporters
