// Rims at high depth jumps that end inside of their own surfaces.
#include <gtest/gtest.h>

#include <cmath>

#include "sheet_scene.h"

namespace hexrelief::testing_mesher {
namespace {

TEST(RimInset, EndsRimsOfHighStepsInsideOfTheirSurfaces) {
    const auto opened = [](double near, double inset_px) {
        Scene scene([=](double x, double y) { return disc(x, y, near, 20); });
        scene.config.rim_inset_px = inset_px;
        return scene.open();
    };
    const SheetMesh on = opened(60, 0), inside = opened(60, 0.25);
    expect_sound(inside);
    EXPECT_EQ(on.triangles, inside.triangles);
    EXPECT_EQ(on.disparities, inside.disparities);
    const double around = 2 * 3.14159 * 33.4;
    EXPECT_NEAR(area(on) - area(inside), 2 * 0.25 * around, 0.05 * around);
    const std::vector<std::uint32_t> rim = rim_vertices(on);
    for (const std::uint32_t v : rim) {
        const auto out = [&](const Vec2f& p) { return std::hypot(p.x - 71.3, p.y - 58.6); };
        const double moved = out(inside.points[v]) - out(on.points[v]);
        EXPECT_NEAR(moved, on.disparities[v] > 40 ? -0.25 : 0.25, 0.05);
    }
    EXPECT_EQ(opened(22, 0).points, opened(22, 0.25).points) << "through the gap, the error would be larger";
}

TEST(RimInset, HoldsAboveBackgroundButNotAtTheUnknown) {
    for (const double behind : {20.0, double(NAN)}) {
        Scene scene([=](double x, double y) { return disc(x, y, 60, behind); });
        scene.background_px = 30;
        const SheetMesh on = scene.open();
        scene.config.rim_inset_px = 0.25;
        const SheetMesh inside = scene.open();
        expect_sound(inside);
        const double around = 2 * 3.14159 * 33.4;
        EXPECT_NEAR(area(on) - area(inside), std::isnan(behind) ? 0 : 0.25 * around, 0.03 * around);
    }
}

}  // namespace
}  // namespace hexrelief::testing_mesher
