// What the left camera does not see, on a made-up scene: a box of 20 px of disparity before a wall of 4 px.
#include <gtest/gtest.h>

#include <algorithm>

#include <array>
#include <cstddef>
#include <tuple>

#include "pipeline/stages/other_views/behind_silhouettes.h"
#include "pipeline/stages/other_views/other_view.h"
#include "pipeline/stages/other_views/small_regions.h"
#include "pipeline/stages/surface.h"

namespace hexrelief::stages {
namespace {

constexpr double kAnyStep_px = 1e9;
constexpr int kWidth = 100, kHeight = 40, kThreads = 2;
constexpr float kBox = 20, kWall = 4;
constexpr int kBoxBegin = 40, kBoxEnd = 60;  // columns of the left view

void add_rectangle(SurfaceMesh& mesh, float x, float end, float disparity) {
    const auto first = static_cast<std::uint32_t>(mesh.image_points.size());
    for (const Vec2f& p : {Vec2f{x, 0}, {end, 0}, {x, kHeight}, {end, kHeight}}) {
        mesh.image_points.push_back(p);
        mesh.disparities.push_back(disparity);
    }
    mesh.triangles.push_back({first, first + 2, first + 1});
    mesh.triangles.push_back({first + 1, first + 2, first + 3});
}

SurfaceMesh left_surface() {
    SurfaceMesh mesh;
    add_rectangle(mesh, 0, kBoxBegin, kWall);
    add_rectangle(mesh, kBoxBegin, kBoxEnd, kBox);
    add_rectangle(mesh, kBoxEnd, kWidth, kWall);
    return mesh;
}

ViewPlace place_at(double right, double up = 0, double shift_px = 0, double scale = 1) {
    return {right, up, shift_px, scale, static_cast<int>(kWidth / scale), static_cast<int>(kHeight / scale)};
}

// The right view: the box at columns 20 to 40, the wall around it.
OtherView right_view() {
    OtherView view{place_at(1), {kWidth, kHeight, std::vector<float>(kWidth * kHeight, kWall)}, {}, {}};
    for (int y = 0; y < kHeight; ++y)
        for (int x = kBoxBegin - 20; x < kBoxEnd - 20; ++x) view.map.at(x, y) = kBox;
    return view;
}

TEST(ViewPlace, PointsAndCamerasAgree) {
    const Calibration left{.focal_px = 120, .cx = 48, .cy = 21, .baseline_m = 0.2, .doffs_px = 3};
    for (const ViewPlace& place : {place_at(1, 0, 2.5), place_at(-0.5, 0.75, 4, 2), place_at(0, -1, 0, 2)}) {
        const ViewPoint there = place.from_left({30, 12, 17}), back = place.to_left(there);
        EXPECT_NEAR(back.x, 30, 1e-12);
        EXPECT_NEAR(back.y, 12, 1e-12);
        EXPECT_NEAR(back.d, 17, 1e-12);
        const std::array<double, 3> here = position_in_space(30, 12, 17, left),
                                    seen =
                                        position_in_space(there.x, there.y, there.d, camera_at(place, left));
        EXPECT_NEAR(seen[0] + place.right * left.baseline_m, here[0], 1e-12);
        EXPECT_NEAR(seen[1] + place.up * left.baseline_m, here[1], 1e-12);
        EXPECT_NEAR(seen[2], here[2], 1e-12);
    }
}

TEST(OtherView, MissingIsWhatOnlyTheRightCameraSees) {
    const SurfaceMesh mesh = left_surface();
    OtherView view = right_view();
    find_missing(view, see(mesh, place_at(1), kThreads), see(mesh, place_at(0), kThreads), false, kThreads);
    for (int x = 0; x < kWidth; ++x) {
        // The wall right of the box, which hid it from the left camera, and right of the left view's border.
        const bool is_missing = (x >= 40 && x < 56) || x >= 96;
        EXPECT_EQ(view.missing.at(x, 20), is_missing ? kWall : kUnknownDisparity) << x;
    }
}

TEST(OtherView, WhatTheLeftCameraWouldSeeInFrontIsReplacedByTheFartherSurface) {
    const SurfaceMesh mesh = left_surface();
    OtherView view = right_view();
    for (int x = 40; x < 45; ++x) view.map.at(x, 20) = kBox;  // the box seems wider than the left view's
    view.map.at(50, 20) = kUnknownDisparity;
    find_missing(view, see(mesh, place_at(1), kThreads), see(mesh, place_at(0), kThreads), false, kThreads);
    for (int x = 40; x < 45; ++x) EXPECT_EQ(view.missing.at(x, 20), kWall) << x;
    EXPECT_EQ(view.missing.at(50, 20),
              kUnknownDisparity);  // what the right view does not know is not made up
}

TEST(OtherView, WhatContinuesNothingInItsRowIsReplacedByTheFartherSurfaceIfAsked) {
    const SurfaceMesh mesh = left_surface();
    for (const bool only_joined : {false, true}) {
        OtherView view = right_view();
        view.map.at(46, 20) = kWall + 6;
        find_missing(view, see(mesh, place_at(1), kThreads), see(mesh, place_at(0), kThreads), only_joined,
                     kThreads);
        EXPECT_EQ(view.missing.at(46, 20), only_joined ? kWall : kWall + 6);
        EXPECT_EQ(view.missing.at(47, 20), kWall);
    }
}

TEST(OtherView, InTheFrameIsWhatLiesBesideWhatTheLeftViewShows) {
    const SurfaceMesh mesh = left_surface();
    const SeenSurface in_left = see(mesh, place_at(0), kThreads);
    OtherView view = right_view();
    find_missing(view, see(mesh, place_at(1), kThreads), in_left, false, kThreads);
    keep_in_frame(view, frame_of(in_left, 0));
    for (int x = 0; x < kWidth; ++x)  // no longer right of the left view's border
        EXPECT_EQ(view.missing.at(x, 20), x >= 40 && x < 56 ? kWall : kUnknownDisparity) << x;
}

TEST(OtherView, CutMeshesEndAtTheBorderOfWhatTheLeftViewShows) {
    const SeenSurface in_left = see(left_surface(), place_at(0), kThreads);
    const Frame frame = frame_of(in_left, 0);
    // Of the right view: 10 px right of the left view's border, and one triangle that is all beyond it.
    DisparityMesh mesh{{{80, 10}, {90, 30}, {106, 10}, {100, 10}, {100, 20}, {106, 20}},
                       std::vector<float>(6, kWall),
                       {{0, 2, 1}, {3, 5, 4}}};
    move_into_frame(mesh, place_at(1), frame, in_left, 2);
    EXPECT_EQ(mesh.points[2], (Vec2f{96, 10}));
    EXPECT_EQ(mesh.points[0], (Vec2f{80, 10}));
    EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 2, 1}}));
}

TEST(OtherView, WhatTurnsOutBehindANearBorderComesForwardToIt) {
    // All of the left view is near; a sheet 4 px of disparity behind it.
    SeenSurface near{place_at(0), Disparities(kWidth * kHeight, kWall + 4.0)};
    const Frame frame = frame_of(near, 2);
    // A camera 2 baselines beside it sees the sheet 8 px farther out: that much of the border comes forward.
    DisparityMesh mesh{{{kWidth, 30}, {kWidth - 4, 36}, {kWidth - 8, 30}}, std::vector<float>(3, kWall), {}};
    move_into_frame(mesh, place_at(0), frame, near, 0);
    EXPECT_EQ(mesh.disparities, (std::vector<float>{kWall + 4, kWall + 2, kWall}));
    // Where the surface goes on with a farther one the sheet stays.
    near.disparities[32 * kWidth + kWidth - 1] = kWall;
    DisparityMesh joined{{{kWidth, 30}}, {kWall}, {}};
    move_into_frame(joined, place_at(0), frame, near, 3);
    EXPECT_EQ(joined.disparities, (std::vector<float>{kWall}));
}

// The left view with nothing missing yet: the box has the colour 200, the wall 90.
OtherView left_view(const SeenSurface& seen) {
    OtherView view{seen.place, {kWidth, kHeight, {seen.disparities.begin(), seen.disparities.end()}}};
    view.missing = view.map;
    view.missing.values.assign(view.map.values.size(), kUnknownDisparity);
    view.color = {kWidth, kHeight, 1, std::vector<std::uint8_t>(kWidth * kHeight, 90)};
    for (int y = 0; y < kHeight; ++y)
        for (int x = kBoxBegin; x < kBoxEnd; ++x) *view.color.at(x, y) = 200;
    view.picture = {kWidth / 2, kHeight / 2, 1, std::vector<std::uint8_t>(kWidth * kHeight / 4, 200)};
    for (int y = 0; y < kHeight / 2; ++y)
        for (int x = 0; x < kBoxBegin / 2; ++x) *view.picture.at(x, y) = 90;
    return view;
}

TEST(OtherView, ContinuedBehindTheBoxIsTheWallInItsColours) {
    const VisibleSurface visible =
        visible_surface(left_surface(), {place_at(0), place_at(1)}, kWall - 1, kThreads);
    OtherView view = left_view(visible.seen[0]);
    paint_behind(view, continue_behind(view, visible.seen[0], {.left = 0.5}, visible, kThreads), nullptr,
                 kThreads);
    // From half a baseline to the left the box is 8 px farther to the right of the wall than from the left
    // camera. A sixteenth of the view continues at most.
    for (int x = 0; x < kWidth; ++x) {
        const bool is_continued = x >= kBoxBegin && x < kBoxBegin + kWidth / 16;
        EXPECT_EQ(DisparityMap::known(view.missing.at(x, 20)), is_continued) << x;
        if (!is_continued) continue;
        EXPECT_NEAR(view.missing.at(x, 20), kWall, 0.5) << x;
        EXPECT_EQ(*view.picture.at(x / 2, 10), 90) << x;
    }
    EXPECT_EQ(*view.picture.at((kBoxBegin + 14) / 2, 10), 200);  // the box beyond what its filter needs
}

TEST(OtherView, ANarrowOutlineIsNoColourOfAPhotographsWallAWiderStripIs) {
    const VisibleSurface visible = visible_surface(left_surface(), {place_at(0)}, kWall - 1, kThreads);
    for (const int strip_px : {4, 10}) {
        OtherView view = left_view(visible.seen[0]);
        view.picture = {};
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kWidth; ++x)
                *view.color.at(x, y) = x < kBoxBegin - strip_px || x >= kBoxEnd ? 90
                                       : x < kBoxBegin                          ? 20
                                                                                : 200;
        paint_behind(
            view,
            continue_behind(view, visible.seen[0], {.left = 1, .mixed_px = Beyond::kMixedOfPhotographs_px},
                            visible, kThreads),
            nullptr, kThreads);
        for (int x = kBoxBegin - strip_px; x < kBoxBegin; ++x)
            EXPECT_NEAR(*view.color.at(x, 20), strip_px == 4 ? 90 : 20, 2) << x;
        if (strip_px > 4) continue;
        // What continues, and what triangles show beside it.
        for (int x = kBoxBegin; x < kBoxEnd; ++x) EXPECT_NEAR(*view.color.at(x, 20), 90, 2) << x;
    }
}

TEST(OtherView, AWallWithoutAnOutlineKeepsItsColours) {
    const VisibleSurface visible = visible_surface(left_surface(), {place_at(0)}, kWall - 1, kThreads);
    OtherView view = left_view(visible.seen[0]);
    view.picture = {};
    for (int i = 0; i < kWidth * kHeight; ++i)
        view.color.pixels[i] = i % kWidth < kBoxBegin || i % kWidth >= kBoxEnd ? 90 + i % 5 : 200;
    const Image before = view.color;
    paint_behind(view,
                 continue_behind(view, visible.seen[0],
                                 {.left = 1, .mixed_px = Beyond::kMixedOfPhotographs_px}, visible, kThreads),
                 nullptr, kThreads);
    for (int x = 0; x < kBoxBegin; ++x) EXPECT_EQ(*view.color.at(x, 20), *before.at(x, 20)) << x;
}

TEST(OtherView, NoSurfaceContinuesFartherThanASixteenthOfTheView) {
    const VisibleSurface visible = visible_surface(left_surface(), {place_at(0)}, kWall - 1, kThreads);
    OtherView view = left_view(visible.seen[0]);
    continue_behind(view, visible.seen[0], {.left = 8, .right = 8, .up = 8, .down = 8}, visible, kThreads);
    for (int x = 0; x < kWidth; ++x) {  // above and below the box there is no wall
        const bool is_near_its_end = std::min(x - kBoxBegin, kBoxEnd - 1 - x) < kWidth / 16;
        EXPECT_EQ(DisparityMap::known(view.missing.at(x, 20)),
                  x >= kBoxBegin && x < kBoxEnd && is_near_its_end)
            << x;
    }
    OtherView wide = left_view(visible.seen[0]);
    continue_behind(wide, visible.seen[0], {.left = 8}, visible, kThreads);
    EXPECT_EQ(wide.missing.at(kBoxBegin + kWidth / 16, 20), kUnknownDisparity);
}

TEST(OtherView, NothingContinuesBehindABorderWithoutASurfaceBehindIt) {
    SurfaceMesh box;
    add_rectangle(box, kBoxBegin, kBoxEnd, kBox);
    const VisibleSurface visible = visible_surface(box, {place_at(0)}, kWall - 1, kThreads);
    OtherView view = left_view(visible.seen[0]);
    continue_behind(view, visible.seen[0], {.left = 1, .right = 1, .up = 1, .down = 1}, visible, kThreads);
    for (const float d : view.missing.values) EXPECT_EQ(d, kUnknownDisparity);
}

TEST(OtherView, PartsOverlapWithTheSurfaceAndSmallOnesJoinThoseAroundThem) {
    const VisibleSurface visible = visible_surface(left_surface(), {place_at(0)}, kWall - 1, kThreads);
    OtherView view = left_view(visible.seen[0]);
    for (int y = 5; y < 35; ++y)
        for (int x = kBoxBegin; x < kBoxBegin + 6; ++x) view.missing.at(x, y) = kWall;
    view.missing.at(kBoxBegin + 2, 20) = 12;
    view.missing.at(90, 20) = kWall;  // nobody would miss it
    join_to_surface(view, visible.seen[0], 5, kLeastSurface, 2);
    EXPECT_EQ(view.missing.at(kBoxBegin + 2, 20), kWall);
    EXPECT_EQ(view.missing.at(90, 20), kUnknownDisparity);
    for (int x = kBoxBegin - 5; x < kBoxBegin; ++x) EXPECT_EQ(view.missing.at(x, 20), kWall) << x;
    EXPECT_EQ(view.missing.at(kBoxBegin - 6, 20), kUnknownDisparity);
    EXPECT_EQ(view.missing.at(kBoxBegin + 7, 20), kUnknownDisparity);
}

TEST(OtherView, PartsInFrontOfTheSurfaceAreClipped) {
    const VisibleSurface visible = visible_surface(left_surface(), {place_at(0)}, kWall, kThreads);
    DisparityMesh sheet;  // in the right view, at 10 px: behind the box, in front of the wall
    sheet.points = {{30, 10}, {60, 10}, {30, 30}};
    sheet.disparities = {10, 10, 10};
    sheet.triangles = {{0, 1, 2}};
    keep_behind(sheet, place_at(1), visible, kAnyStep_px, 2);
    EXPECT_FALSE(sheet.triangles.empty());
    for (const Triangle& t : sheet.triangles)
        for (const std::uint32_t v : t) {
            const ViewPoint p =
                place_at(1).to_left({sheet.points[v].x, sheet.points[v].y, sheet.disparities[v]});
            EXPECT_LE(p.d, visible.seen[0].limit_at(p)) << p.x;
        }
}

TEST(OtherView, NoVertexLiesOnTheEdgeOfATriangleBesideASplitOne) {
    const VisibleSurface visible = visible_surface(left_surface(), {place_at(0)}, 1, kThreads);
    DisparityMesh sheet;  // from behind the wall to behind the box, beside a triangle that is behind all
    sheet.points = {{20, 10}, {50, 10}, {20, 30}, {5, 20}};
    sheet.disparities = {3, 18, 3, 3};
    sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
    keep_behind(sheet, place_at(0), visible, kAnyStep_px, 2);
    EXPECT_GT(sheet.triangles.size(), 4u);
    for (const Triangle& t : sheet.triangles)
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec2f &a = sheet.points[t[k]], &b = sheet.points[t[(k + 1) % 3]];
            for (const Triangle& other : sheet.triangles)
                for (const std::uint32_t v : other) {
                    const Vec2f& p = sheet.points[v];
                    const bool is_between = (p.x - a.x) * (b.y - a.y) == (p.y - a.y) * (b.x - a.x) &&
                                            (p.x - a.x) * (p.x - b.x) + (p.y - a.y) * (p.y - b.y) < 0;
                    EXPECT_FALSE(is_between) << p.x << " " << p.y;
                }
        }
}

TEST(OtherView, ATriangleThatMovingMakesStepIsDropped) {
    for (const double most_step_px : {6.0, 18.0}) {
        const VisibleSurface visible = visible_surface(left_surface(), {place_at(0)}, 1, kThreads);
        DisparityMesh
            sheet;  // flat behind the box, but its last vertex comes out beside it and moves behind the wall
        sheet.points = {{44, 10}, {54, 10}, {44, 20}, {60.5F, 10}};
        sheet.disparities = {15, 15, 15, 15};
        sheet.triangles = {{0, 2, 1}, {1, 2, 3}};
        keep_behind(sheet, place_at(0), visible, most_step_px, 2);
        EXPECT_EQ(sheet.triangles.size(), most_step_px > 15 ? 2u : 1u) << most_step_px;
    }
}

// A place of a view of 40,000 px: pieces of 20 px and more stay.
ViewPlace large_place_at(double right) {
    ViewPlace place = place_at(right);
    place.height = 40000 / place.width;
    return place;
}

TEST(OtherView, PiecesThatNobodyWouldMissAreDropped) {
    const VisibleSurface visible = visible_surface(left_surface(), {place_at(0)}, 1, kThreads);
    DisparityMesh sheet;  // behind all: pieces of 18, of twice 12.5 and of 24.5 square pixels
    sheet.points = {{5, 5},   {11, 5},  {5, 11}, {15, 5}, {20, 5},
                    {15, 10}, {20, 10}, {25, 5}, {32, 5}, {25, 12}};
    sheet.disparities.assign(sheet.points.size(), 2);
    sheet.triangles = {{0, 2, 1}, {3, 5, 4}, {4, 5, 6}, {7, 9, 8}};
    keep_behind(sheet, large_place_at(0), visible, kAnyStep_px, 2);
    EXPECT_EQ(sheet.triangles, (std::vector<Triangle>{{3, 5, 4}, {4, 5, 6}, {7, 9, 8}}));
}

TEST(OtherView, SmallPiecesThatFillAHoleAreKept) {
    const VisibleSurface visible = visible_surface(left_surface(), {place_at(0), place_at(1)}, 1, kThreads);
    DisparityMesh sheet;  // behind all: 18 square pixels behind the wall, 18 and 2 where the box hid it
    sheet.points = {{5, 5}, {11, 5}, {5, 11}, {42, 5}, {48, 5}, {42, 11}, {42, 20}, {44, 20}, {42, 22}};
    sheet.disparities.assign(sheet.points.size(), 2);
    sheet.triangles = {{0, 2, 1}, {3, 5, 4}, {6, 8, 7}};
    keep_behind(sheet, large_place_at(1), visible, kAnyStep_px, 2);
    EXPECT_EQ(sheet.triangles, (std::vector<Triangle>{{3, 5, 4}}));
}

TEST(OtherView, APointBehindEverythingIsUnknown) {
    const VisibleSurface visible = visible_surface(left_surface(), {place_at(0)}, kWall, kThreads);
    EXPECT_EQ(behind({30, 20, kWall - 2.0}, place_at(1), visible), kUnknownDisparity);
    EXPECT_EQ(behind({10, 20, kWall}, place_at(1), visible), kWall);
    EXPECT_EQ(behind({45, 20, kBox}, place_at(1), visible), kWall);
}

TEST(OtherView, TheMirroredPairHasTheRightCameraOnTheLeft) {
    StereoPair pair{{2, 1, 1, {1, 2}}, {2, 1, 1, {3, 4}}};
    pair.left.alpha = {5, 6};
    const StereoPair mirror = mirrored(pair);
    EXPECT_EQ(mirror.left.pixels, (std::vector<std::uint8_t>{4, 3}));
    EXPECT_EQ(mirror.right.pixels, (std::vector<std::uint8_t>{2, 1}));
    EXPECT_EQ(mirror.right.alpha, (std::vector<std::uint8_t>{6, 5}));
    EXPECT_EQ(mirrored(DisparityMap{3, 1, {1, 2, 3}}).values, (std::vector<float>{3, 2, 1}));
}

// A sheet of the right view at all disparities, whose triangles are partly in front of what cameras see.
DisparityMesh wavy_sheet() {
    constexpr std::uint32_t kColumns = 21, kRows = 9;
    DisparityMesh sheet;
    for (std::uint32_t row = 0; row < kRows; ++row)
        for (std::uint32_t column = 0; column < kColumns; ++column) {
            const auto at = static_cast<std::uint32_t>(sheet.points.size());
            sheet.points.push_back({column * 4.5f, row * 4.5f});
            sheet.disparities.push_back(3 + static_cast<float>(7 * column + 5 * row) / 12);
            if (row == 0 || column == 0) continue;
            sheet.triangles.push_back({at - kColumns - 1, at - 1, at - kColumns});
            sheet.triangles.push_back({at - kColumns, at - 1, at});
        }
    return sheet;
}

TEST(OtherView, IsTheSameOnAnyNumberOfThreads) {
    const auto made_by = [](int threads) {
        VisibleSurface visible =
            visible_surface(left_surface(), {place_at(0), place_at(1)}, kWall - 1, threads);
        OtherView view = left_view(visible.seen[0]);
        paint_behind(view,
                     continue_behind(view, visible.seen[0], {.left = 1, .right = 1, .up = 1, .down = 1},
                                     visible, threads),
                     nullptr, threads);
        join_to_surface(view, visible.seen[0], 2, kLeastSurface, threads);
        DisparityMesh sheet = wavy_sheet();
        keep_behind(sheet, place_at(1), visible, kAnyStep_px, threads);
        SurfaceMesh added = left_surface();
        for (const Vec2f& p : sheet.points) added.image_points.push_back(p);
        added.disparities.insert(added.disparities.end(), sheet.disparities.begin(), sheet.disparities.end());
        const std::vector<Provenance> provenance = provenance_of(added, visible.seen, threads);
        cover(visible, left_surface(), threads);
        return std::tuple(view.missing.values, view.color.pixels, view.picture.pixels, sheet.points,
                          sheet.disparities, sheet.triangles, provenance, visible.seen[1].disparities);
    };
    const auto alone = made_by(1);
    EXPECT_GT(std::get<5>(alone).size(), wavy_sheet().triangles.size()) << "some are split";
    EXPECT_EQ(made_by(2), alone);
    EXPECT_EQ(made_by(7), alone);
}

}  // namespace
}  // namespace hexrelief::stages
