// Tests the insetting of silhouettes at high depth discontinuities.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/mesher/surface/made_up_scene.h"

namespace hexrelief::surface {
namespace {

TEST(SilhouetteInset, EndsSilhouettesOfHighStepsInsideOfTheirSurfaces) {
    const auto opened = [](double near, double inset_px) {
        Scene scene([=](double x, double y) { return disc(x, y, near, 20); });
        scene.config.silhouette_inset_px = inset_px;
        return scene.open();
    };
    const DisparityMesh on = opened(60, 0), inside = opened(60, 0.25);
    expect_sound(inside);
    EXPECT_EQ(on.triangles, inside.triangles);
    EXPECT_EQ(on.disparities, inside.disparities);
    const double around = 2 * 3.14159 * 33.4;
    EXPECT_NEAR(area(on) - area(inside), 2 * 0.25 * around, 0.05 * around);
    const std::vector<std::uint32_t> silhouette = silhouette_vertices(on);
    for (const std::uint32_t v : silhouette) {
        const auto out = [&](const Vec2f& p) { return std::hypot(p.x - 71.3, p.y - 58.6); };
        const double moved = out(inside.points[v]) - out(on.points[v]);
        EXPECT_NEAR(moved, on.disparities[v] > 40 ? -0.25 : 0.25, 0.05);
    }
    EXPECT_EQ(opened(22, 0).points, opened(22, 0.25).points) << "through the gap, the error would be larger";
}

TEST(SilhouetteInset, HoldsAboveBackgroundButNotAtTheUnknown) {
    for (const double behind : {20.0, double(NAN)}) {
        Scene scene([=](double x, double y) { return disc(x, y, 60, behind); });
        scene.background_px = 30;
        const DisparityMesh on = scene.open();
        scene.config.silhouette_inset_px = 0.25;
        const DisparityMesh inside = scene.open();
        expect_sound(inside);
        const double around = 2 * 3.14159 * 33.4;
        EXPECT_NEAR(area(on) - area(inside), std::isnan(behind) ? 0 : 0.25 * around, 0.03 * around);
    }
}

TEST(SilhouetteInset, UncoversNoPixelAwayFromHighSteps) {
    // The step's height changes along a wavy silhouette, so that high and low steps alternate.
    const auto silhouette = [](double y) { return 70 + 9 * std::sin(y / 7); };
    const auto near_px = [](double y) { return 30 + 5 * std::fabs(std::sin(y / 11)); };
    Scene scene([&](double x, double y) { return x < silhouette(y) ? near_px(y) : 30.0; });
    const DisparityMesh on = scene.open();
    scene.config.silhouette_inset_px = 0.4;
    const DisparityMesh inside = scene.open();
    expect_sound(inside);
    EXPECT_GT(area(on) - area(inside), 10) << "rims of high steps are inset";
    const auto covers = [](const DisparityMesh& s, double x, double y) {
        return std::any_of(s.triangles.begin(), s.triangles.end(), [&](const Triangle& t) {
            for (int k = 0; k < 3; ++k) {
                const Vec2f &a = s.points[t[k]], &b = s.points[t[(k + 1) % 3]];
                if ((double(b.x) - a.x) * (y - a.y) - (double(b.y) - a.y) * (x - a.x) < -1e-5) return false;
            }
            return true;
        });
    };
    const auto at = [&](int x, int y) { return scene.map.values[static_cast<std::size_t>(y) * kWidth + x]; };
    int uncovered = 0, at_steps = 0;
    for (int y = 1; y + 1 < kHeight; ++y)
        for (int x = 55; x < 85; ++x) {
            if (!covers(on, x + 0.5, y + 0.5) || covers(inside, x + 0.5, y + 0.5)) continue;
            const float d = at(x, y), most = 2.3f;
            const bool high = std::fabs(at(x - 1, y) - d) > most || std::fabs(at(x + 1, y) - d) > most ||
                              std::fabs(at(x, y - 1) - d) > most || std::fabs(at(x, y + 1) - d) > most;
            ++(high ? at_steps : uncovered);
        }
    EXPECT_EQ(uncovered, 0);
    EXPECT_GT(at_steps, 0) << "there the gap may be";
}

}  // namespace
}  // namespace hexrelief::surface
