// What the left camera does not see in supplied maps, and what they do not know, on a made-up scene: a box of
// 20 px of disparity before a wall of 6 px.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <utility>
#include <vector>

#include "pipeline/config/reader.h"
#include "pipeline/data/union_find.h"
#include "pipeline/job/runner.h"
#include "pipeline/stages/other_views/view_place.h"
#include "tests/pipeline/process.h"

namespace hexrelief::job {
namespace {

constexpr int kWidth = 160, kHeight = 120, kScale = 4;
constexpr int kBox = 20, kWall = 6;

// Rows of one disparity each, as the left camera sees them.
struct Thing {
    int x, y, width, height;
    std::vector<int> disparities = std::vector<int>(height, kBox);  // of the rows, px
};
const Thing kOneBox{60, 40, 40, 40};

struct Scene {
    std::vector<int> left, right;  // disparities, px; 0 = unknown
    std::vector<int> left_color = std::vector<int>(kWidth * kHeight), right_color = left_color;

    // A wall and things in front of it, the farthest first.
    explicit Scene(const std::vector<Thing>& things = {kOneBox})
        : left(kWidth * kHeight, kWall), right(left) {
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kWidth; ++x) {
                left_color[y * kWidth + x] = 60 + (x * 7 + y * 3) % 30;
                right_color[y * kWidth + x] = 60 + ((x + kWall) * 7 + y * 3) % 30;
            }
        for (const Thing& thing : things)
            for (int y = 0; y < thing.height; ++y)
                for (int x = 0; x < thing.width; ++x) {
                    const int d = thing.disparities[y], color = 180 + (x * 5 + thing.y + y) % 20;
                    put(left, left_color, thing.x + x, thing.y + y, d, color);
                    put(right, right_color, thing.x + x - d, thing.y + y, d, color);
                }
    }
    static void put(std::vector<int>& map, std::vector<int>& color, int x, int y, int d, int value) {
        if (x < 0 || x >= kWidth) return;
        map[y * kWidth + x] = d;
        color[y * kWidth + x] = value;
    }
};

// Teeth of 8 px with gaps of 12 px, joined below.
std::vector<Thing> comb() {
    std::vector<Thing> things = {{20, 90, 108, 10}};
    for (int x = 20; x < 140; x += 20) things.push_back({x, 30, 8, 60});
    return things;
}

// A box on a floor, which rises by a step in every fourth row.
std::vector<Thing> box_on_floor() {
    Thing floor{-kWidth, 60, 3 * kWidth, 60};
    for (int y = 0; y < floor.height; ++y) floor.disparities[y] = kWall + y / 4;
    return {floor, kOneBox};
}

std::filesystem::path saved(const std::filesystem::path& file, const std::vector<int>& values, int scale) {
    std::ofstream out(file, std::ios::binary);
    out << "P5 " << kWidth << " " << kHeight << " 255\n";
    for (const int value : values) out.put(static_cast<char>(value * scale));
    return file;
}

class WholeMap : public testing::Test {
  protected:
    RunReport run(const std::vector<std::string>& settings, bool with_right = false, bool with_color = true) {
        DisparityFiles files{saved(folder_ / "left.pgm", scene_.left, kScale)};
        if (with_color) files.color = saved(folder_ / "left_color.pgm", scene_.left_color, 1);
        if (with_right) {
            files.right = saved(folder_ / "right.pgm", scene_.right, kScale);
            files.color_right = saved(folder_ / "right_color.pgm", scene_.right_color, 1);
        }
        RunRequest request{.source = files,
                           .outputs = {folder_ / "a.glb"},
                           .config = {.input = {.disparity = {.scale = kScale}}},
                           .report = folder_ / "a.json"};
        for (const std::string& setting : settings) config::apply_setting(request.config, setting);
        return run_job(request);
    }
    static stages::Disparities seen(const SurfaceMesh& mesh, double right, double up = 0) {
        return stages::see(mesh, {right, up, up == 0 ? 0.0 : kWall, 1, kWidth, kHeight}, 2).disparities;
    }
    // Returns the share of the pixels of the wall's own field that show nothing from there.
    static double holes(const SurfaceMesh& mesh, double right, double up = 0) {
        const stages::Disparities disparities = seen(mesh, right, up);
        int open = 0, all = 0;
        for (int y = 0; y < kHeight; ++y)
            for (int x = 20; x < kWidth - 20; ++x, ++all)
                open += disparities[y * kWidth + x] == stages::kNotCovered;
        return static_cast<double>(open) / all;
    }
    static SurfaceMesh left_part(SurfaceMesh mesh) {
        mesh.triangles.resize(mesh.left_triangles());
        return mesh;
    }

    test::TemporaryFolder folder_;
    Scene scene_;
};

TEST_F(WholeMap, WhatNobodySawContinuesBehindTheBox) {
    const SurfaceMesh whole = run({}).relief->surface.mesh,
                      left = run({"surface.behind=0"}).relief->surface.mesh;
    EXPECT_EQ(left.left_triangles(), left.triangles.size());
    for (const double t : {-1.0, -0.5, 0.5, 1.0, 1.5}) {
        EXPECT_GT(holes(left, t), 0.01) << t;
        EXPECT_LT(holes(whole, t), 0.002) << t;
    }
    for (const double up : {-1.0, 1.0}) {
        EXPECT_GT(holes(left, 0, up), 0.01) << up;
        EXPECT_LT(holes(whole, 0, up), 0.002) << up;
    }
}

TEST_F(WholeMap, WhatNobodySawHasNoSilhouettesOfItsOwn) {
    // The wall's lower half is 4 px nearer: a silhouette, but not behind the box.
    for (std::size_t i = kWidth * kHeight / 2; i < scene_.left.size(); ++i)
        if (scene_.left[i] == kWall) scene_.left[i] += 4;
    const SurfaceMesh mesh = run({}).relief->surface.mesh;
    const std::vector<Triangle> hidden(
        mesh.triangles.begin() + static_cast<std::ptrdiff_t>(mesh.left_triangles()), mesh.triangles.end());
    UnionFind pieces(mesh.positions.size());
    for (const Triangle& t : hidden) {
        pieces.join(t[0], t[1]);
        pieces.join(t[0], t[2]);
    }
    ASSERT_FALSE(hidden.empty());
    for (const Triangle& t : hidden) {  // what continues is one piece, the backing another
        const std::uint32_t piece = pieces.find(t[0]);
        ASSERT_TRUE(piece == pieces.find(hidden.front()[0]) || piece == pieces.find(hidden.back()[0]));
    }
}

TEST_F(WholeMap, TheReportTellsTheHoles) {
    const RunReport left = run({"surface.behind=0"}), whole = run({}), both = run({"surface.behind=0"}, true);
    // Of the wall's 154 columns, and of 120 rows, the box hides 14 from each side, over 40 of the others.
    EXPECT_NEAR(left.holes.right, 14. * 40 / (154 * 120), 0.002);
    EXPECT_NEAR(left.holes.above, 14. * 40 / (160 * 106), 0.002);
    EXPECT_LT(both.holes.right, 0.001);
    EXPECT_GT(both.holes.above, 0.02);
    EXPECT_LT(whole.holes.right, 0.002);
    EXPECT_LT(whole.holes.above, 0.002);
}

TEST_F(WholeMap, NothingIsInFrontOfWhatTheCamerasSee) {
    for (const bool with_right : {false, true}) {
        const SurfaceMesh mesh = run({}, with_right).relief->surface.mesh;
        EXPECT_GT(mesh.triangles.size(), mesh.left_triangles());
        EXPECT_EQ(seen(mesh, 0), seen(left_part(mesh), 0));
        const stages::Disparities all = seen(mesh, 1), left = seen(left_part(mesh), 1);
        for (std::size_t i = 0; i < all.size(); ++i) {
            if (left[i] == stages::kNotCovered) continue;
            ASSERT_EQ(all[i], left[i]) << i % kWidth << " " << i / kWidth;
        }
    }
}

TEST_F(WholeMap, TheRightCameraSeesItsMap) {
    for (const auto& [name, things] :
         {std::pair{"box", std::vector{kOneBox}}, {"comb", comb()}, {"floor", box_on_floor()}}) {
        scene_ = Scene(things);
        const stages::Disparities right = seen(run({}, true).relief->surface.mesh, 1);
        const auto count_of = [&](const auto& counted) {
            int count = 0;
            for (std::size_t i = 0; i < right.size(); ++i) count += counted(right[i], scene_.right[i]);
            return count;
        };
        EXPECT_EQ(count_of([](double d, int) { return d == stages::kNotCovered; }), 0) << name;
        EXPECT_LT(count_of([](double d, int told) { return d > told + 1; }), kWidth * kHeight / 2000) << name;
        EXPECT_LT(count_of([](double d, int told) { return d < told - 1; }), kWidth * kHeight / 200) << name;
    }
}

TEST_F(WholeMap, TheRightViewsMapIsPartOfTheSurface) {
    const RunReport report = run({"surface.behind=0"}, true);
    const SurfaceMesh& mesh = report.relief->surface.mesh;
    EXPECT_GT(mesh.triangles_of(PartOrigin::right), 0u);
    EXPECT_EQ(mesh.triangles_of(PartOrigin::nobody), 0u);
    EXPECT_LT(holes(mesh, 1), 0.001);
    EXPECT_GT(holes(mesh, -0.5), 0.01);
    // Both pictures are in the texture.
    EXPECT_GT(report.relief->surface.texture(report.relief->view())->height, kHeight);
    ASSERT_EQ(report.relief->input.files.size(), 4u);
    EXPECT_EQ(report.relief->input.files[2].role, "disparity right");
    EXPECT_EQ(report.relief->input.files[3].role, "color right");
    EXPECT_EQ(run({"surface.views=left"}, true).relief->surface.mesh.parts.size(), 0u);
}

TEST_F(WholeMap, VerticesTellWhichCamerasSawThem) {
    // A point of the wall is hidden from the camera at t if the box of 40 x 40 px is there in its view.
    const auto is_seen = [](double x, double y, double d, double t, double margin) {
        const double there = x - t * d, box = 60 - t * kBox;
        if (there < -margin || there > kWidth + margin) return false;
        return d > (kBox + kWall) / 2. || there < box + margin || there > box + 40 - margin ||
               y < 40 + margin || y > 80 - margin;
    };
    for (const bool with_right : {true, false}) {
        const SurfaceMesh mesh = run({}, with_right).relief->surface.mesh;
        ASSERT_EQ(mesh.provenance.size(), mesh.positions.size());
        std::size_t right = 0, counts[4] = {};
        for (std::size_t i = 0; i < mesh.provenance.size(); ++i) {
            const Provenance told = mesh.provenance[i];
            // What is within 1 px of an edge may be told as either.
            const auto agrees = [&](bool is_told, double t) {
                const double x = mesh.image_points[i].x, y = mesh.image_points[i].y, d = mesh.disparities[i];
                return is_told == is_seen(x, y, d, t, 1) || is_told == is_seen(x, y, d, t, -1);
            };
            const bool by_right = told == Provenance::both || told == Provenance::right;
            right += agrees(told == Provenance::both || told == Provenance::left, 0) &&
                     (with_right ? agrees(by_right, 1) : !by_right);
            ++counts[static_cast<int>(told)];
        }
        EXPECT_GE(static_cast<double>(right), 0.99 * static_cast<double>(mesh.provenance.size()));
        for (int k = 0; k < 4; ++k) EXPECT_EQ(counts[k] > 0, with_right || k == 1 || k == 3) << k;
    }
    EXPECT_TRUE(run({"surface.views=left"}).relief->surface.mesh.provenance.empty());
}

TEST_F(WholeMap, VerticesTellWhatWasFilledIfAsked) {
    const auto is_unknown = [](float x, float y) { return x > 19.5f && x < 40.5f && y > 9.5f && y < 30.5f; };
    for (int y = 10; y <= 30; ++y)
        for (int x = 20; x <= 40; ++x) scene_.left[y * kWidth + x] = 0;
    for (const std::string views : {"left", "both"}) {
        const std::vector<std::string> settings = {"surface.views=" + views, "export.provenance=matches"};
        const SurfaceMesh mesh = run(settings).relief->surface.mesh;
        ASSERT_EQ(mesh.provenance.size(), mesh.positions.size());
        for (std::size_t i = 0; i < mesh.left_vertices(); ++i)
            EXPECT_EQ(mesh.provenance[i] == Provenance::filled,
                      is_unknown(mesh.image_points[i].x, mesh.image_points[i].y));
        EXPECT_GT(std::count(mesh.provenance.begin(), mesh.provenance.end(), Provenance::filled), 4);
        EXPECT_EQ(std::count(mesh.provenance.begin(), mesh.provenance.end(), Provenance::nobody) > 0,
                  views == "both");
    }
    const SurfaceMesh mesh = run({}).relief->surface.mesh;
    EXPECT_EQ(std::count(mesh.provenance.begin(), mesh.provenance.end(), Provenance::filled), 0);
}

TEST_F(WholeMap, WithoutPicturesTheSurfaceIsTheSame) {
    const SurfaceMesh mesh = run({}, false, false).relief->surface.mesh;
    EXPECT_LT(holes(mesh, 1), 0.002);
    EXPECT_LT(holes(mesh, -0.5), 0.002);
}

TEST_F(WholeMap, OnlyBackgroundThatMattersOpensTheScene) {
    for (const int rows : {1, 6}) {  // a far strip of 0.8 and of 5 % of the view
        scene_ = Scene();
        std::fill_n(scene_.left.begin(), kWidth * rows, 2);
        const SurfaceMesh mesh =
            run({"density.background.method=threshold_px", "density.background.threshold_px=4"})
                .relief->surface.mesh;
        EXPECT_EQ(mesh.triangles_of(PartOrigin::nobody) > 0, rows == 1) << rows;
    }
}

TEST_F(WholeMap, UnknownPixelsThatThePictureShowsLieOnThePlanesAroundThem) {
    for (int y = 60; y < 80; ++y)
        for (int x = 70; x < 90; ++x) scene_.left[y * kWidth + x] = 0;
    for (int y = 5; y < 15; ++y) scene_.left[y * kWidth + 30] = 0;
    const RunReport report = run({});
    const DisparityMap& map = report.relief->disparity.map;
    EXPECT_NEAR(map.at(80, 70), kBox, 0.5);
    EXPECT_NEAR(map.at(30, 10), kWall, 0.5);
    EXPECT_EQ(map.origins[70 * kWidth + 80], PixelOrigin::filled);
    EXPECT_EQ(map.origins[70 * kWidth + 65], PixelOrigin::matched);
    EXPECT_EQ(report.shares.unknown, 0);
    const RunReport open = run({"disparity.fill=none"});
    EXPECT_EQ(open.relief->disparity.map.at(80, 70), kUnknownDisparity);
    EXPECT_GT(open.shares.unknown, 0.01);
    EXPECT_EQ(report.quality.scored_pixels, open.quality.scored_pixels) << "what was filled is not measured";
    // Without a picture nobody sees anything there.
    EXPECT_EQ(run({}, false, false).relief->disparity.map.at(80, 70), kUnknownDisparity);
}

TEST_F(WholeMap, AThingThatIsCutOutStaysSo) {
    for (int& d : scene_.left)
        if (d == kWall) d = 0;
    const RunReport report = run({});
    EXPECT_EQ(report.relief->disparity.map.at(10, 10), kUnknownDisparity);
    EXPECT_EQ(report.relief->surface.mesh.parts.size(), 0u);
}

TEST_F(WholeMap, ARightMapOfAnotherSizeIsAnError) {
    const std::string right = folder_ / "small.pgm";
    std::ofstream(right) << "P5 2 2 255\nabcd";
    const DisparityFiles files{.map = saved(folder_ / "left.pgm", scene_.left, kScale), .right = right};
    const std::string text = test::error_of([&] {
        run_job({.source = files,
                 .outputs = {folder_ / "a.glb"},
                 .config = {.input = {.disparity = {.scale = kScale}}}});
    });
    EXPECT_CONTAINS(text, "small.pgm: it has 2x2 px, but");
    EXPECT_CONTAINS(text, "160x120");
}

}  // namespace
}  // namespace hexrelief::job
