#include "pipeline/job/pictures/stage_pictures.h"

#include <gtest/gtest.h>

#include <sstream>

#include "pipeline/job/pictures/drawing.h"
#include "tests/mesher/regular_lattice.h"

namespace hexrelief::job {
namespace {

TEST(StagePictures, UnknownDisparityIsBlackAndKnownIsNot) {
    DisparityMap map{3, 1, {kUnknownDisparity, 10, 20}};
    const Image picture = disparity_picture(map);
    EXPECT_EQ(picture.at(0, 0)[0] + picture.at(0, 0)[1] + picture.at(0, 0)[2], 0);
    const auto brightness = [&](int x) {
        return picture.at(x, 0)[0] + picture.at(x, 0)[1] + picture.at(x, 0)[2];
    };
    EXPECT_GT(brightness(1), 60);
    EXPECT_GT(brightness(2), brightness(1) + 200);
}

TEST(StagePictures, FlatAndUnknownMapsAreFine) {
    EXPECT_EQ(disparity_picture({2, 1, {5, 5}}).pixels.size(), 6u);
    EXPECT_EQ(disparity_picture({1, 1, {kUnknownDisparity}}).pixels, std::vector<std::uint8_t>(3, 0));
    EXPECT_EQ(density_picture({2, 1, {0, 0}, 0}).pixels, std::vector<std::uint8_t>(2, 0));
}

TEST(StagePictures, DensityIsWhiteAtItsLargest) {
    const Image picture = density_picture({3, 1, {0, 0.125f, 0.5f}, 0});
    EXPECT_EQ(picture.pixels[0], 0);
    EXPECT_EQ(picture.pixels[1], 136);  // 255 * 0.25^(1/2.2)
    EXPECT_EQ(picture.pixels[2], 255);
}

TEST(StagePictures, SamplesFollowTheDensity) {
    DensityMap density{4, 2, {0, 3, 0, 0, 0, 0, 1, 0}, 0};
    const auto points = sample_points(density, 10000, 5);
    ASSERT_EQ(points.size(), 10000u);
    int first = 0;
    double mean_fraction = 0;
    for (const Vec2f& p : points) {
        const int x = static_cast<int>(p.x), y = static_cast<int>(p.y);
        ASSERT_TRUE((x == 1 && y == 0) || (x == 2 && y == 1)) << p.x << " " << p.y;
        first += y == 0;
        mean_fraction += p.x - x;
    }
    EXPECT_NEAR(first, 7500, 200);  // about 4.6 standard deviations
    EXPECT_NEAR(mean_fraction / 10000, 0.5, 0.02);
    EXPECT_EQ(sample_points(density, 100, 5), sample_points(density, 100, 5));
    EXPECT_NE(sample_points(density, 100, 5), sample_points(density, 100, 6));
    EXPECT_TRUE(sample_points({1, 1, {0}, 0}, 10, 1).empty());
}

TEST(StagePictures, MeshObjHoldsAllVerticesInOrderAndExactly) {
    HexMesh2D mesh = mesher::regular_lattice(40, 30, 6);
    mesh.positions[3] = {0.1f, 1.0f / 3};
    std::istringstream text(mesh_obj(mesh));
    std::string line;
    std::size_t vertices = 0, faces = 0;
    while (std::getline(text, line)) {
        if (line[0] == 'f') ++faces;
        if (line[0] != 'v') continue;
        char* rest = nullptr;
        const float x = std::strtof(line.c_str() + 1, &rest);
        const float y = std::strtof(rest, &rest);
        EXPECT_EQ((Vec2f{x, y}), mesh.positions.at(vertices));
        EXPECT_STREQ(rest, " 0");
        ++vertices;
    }
    EXPECT_EQ(vertices, mesh.positions.size());
    EXPECT_EQ(faces, mesh.triangle_count());
}

TEST(StagePictures, MeshIsDrawnOverTheBackdrop) {
    Image grey{60, 40, 1, std::vector<std::uint8_t>(60 * 40, 100)};
    const Image picture = mesh_picture(mesher::regular_lattice(60, 40, 6), grey);
    EXPECT_EQ(picture.width, 120);
    std::size_t lines = 0;
    for (std::size_t i = 0; i < picture.pixels.size(); i += 3) lines += picture.pixels[i] > 150;
    EXPECT_GT(lines, picture.pixels.size() / 3 / 20);
    EXPECT_LT(lines, picture.pixels.size() / 3 / 2);
}

TEST(WeightsPicture, BinsAreTheMeansTwentieths) {
    const std::vector<double> shares = weight_shares({0, 3, 4, 4.09, 8.91, 4});  // mean 4
    ASSERT_EQ(shares.size(), 41u);
    EXPECT_NEAR(shares[0], 1.0 / 6, 1e-12);
    EXPECT_NEAR(shares[15], 1.0 / 6, 1e-12);
    EXPECT_NEAR(shares[20], 3.0 / 6, 1e-12);
    EXPECT_NEAR(shares[40], 1.0 / 6, 1e-12);  // 2.2 times the mean
    EXPECT_TRUE(weight_shares({}).empty());
    EXPECT_TRUE(weight_shares({0, 0}).empty());
}

TEST(WeightsPicture, EqualWeightsAreOneFullBar) {
    const auto dark = [](const Image& picture, int bin) {
        int rows = 0;
        for (int y = 0; y < picture.height; ++y) rows += picture.at(20 * bin + 5, y)[0] < 100;
        return rows;
    };
    const Image equal = weights_picture({5, 5, 5});
    EXPECT_GT(dark(equal, 20), 370);
    for (const int bin : {0, 19, 21, 40}) EXPECT_LT(dark(equal, bin), 5) << bin;
    const Image halves = weights_picture({4, 6});
    EXPECT_EQ(dark(halves, 16), dark(halves, 24));
    EXPECT_GT(dark(halves, 16), 200);
    EXPECT_LT(dark(halves, 16), 300);
    EXPECT_FALSE(weights_picture({}).empty());
}

TEST(Raster, SegmentCoversItsLength) {
    Image picture = blank_picture(20, 5, {0, 0, 0});
    draw_segment(picture, {2.5f, 2.5f}, {17.5f, 2.5f}, {255, 255, 255}, 1, 1);
    EXPECT_EQ(picture.at(10, 2)[0], 255);
    EXPECT_EQ(picture.at(10, 0)[0], 0);
    EXPECT_EQ(picture.at(19, 2)[0], 0);
    draw_segment(picture, {-100, -100}, {100, 100}, {255, 0, 0}, 1,
                 1);  // ends outside the picture; only pixels inside are written
    EXPECT_EQ(picture.at(3, 3)[0], 255);
}

TEST(ReliefPicture, ShowsTheTextureAndHidesWhatLiesBehind) {
    // A red square in front of a green one.
    SurfaceMesh mesh;
    for (const float z : {-2.0f, -1.5f}) {
        const float s = z < -1.9f ? 0.8f : 0.3f, u = z < -1.9f ? 0.75f : 0.25f;
        for (const auto& [x, y] : {std::pair{-s, -s}, {s, -s}, {s, s}, {-s, s}}) {
            mesh.positions.push_back({x, y, z});
            mesh.normals.push_back({0, 0, 1});
            mesh.texcoords.push_back({u, 0.5f});
        }
    }
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}};
    const Image texture{2, 1, 3, {255, 0, 0, 0, 255, 0}};
    const Image picture = render_relief(mesh, &texture);
    EXPECT_EQ(std::max(picture.width, picture.height), 1200);
    const std::uint8_t* middle = picture.at(picture.width / 2, picture.height / 2);
    EXPECT_GT(middle[0], 150);
    EXPECT_LT(middle[1], 20);
    std::size_t green = 0;
    for (std::size_t i = 0; i < picture.pixels.size(); i += 3)
        green += picture.pixels[i + 1] > 150 && picture.pixels[i] < 20;
    EXPECT_GT(green, picture.pixels.size() / 3 / 4);
    EXPECT_FALSE(render_relief(SurfaceMesh{}, nullptr).empty());
}

}  // namespace
}  // namespace hexrelief::job
