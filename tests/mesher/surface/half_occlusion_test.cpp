// Tests that pixels that only the other camera sees, beside steps down to the right and in holes, are left
// to the farther surface.
#include <gtest/gtest.h>

#include <cmath>

#include "mesher/surface/pixels/discontinuities_step.h"
#include "mesher/surface/topology/label_triangles_step.h"
#include "tests/mesher/surface/made_up_scene.h"

namespace hexrelief::surface {
namespace {

// Returns the nearest disparity at (x, y) px; 0 = nothing is there.
double disparity_at(const DisparityMesh& s, double x, double y) {
    double nearest = 0;
    for (const Triangle& t : s.triangles) {
        const double area2 = twice_area(s, t);
        double shares[3], sum = 0;
        for (int k = 0; k < 3; ++k) {
            const Vec2f &a = s.points[t[(k + 1) % 3]], &b = s.points[t[(k + 2) % 3]];
            shares[k] = ((a.x - x) * (b.y - y) - (a.y - y) * (b.x - x)) / area2;
            sum += shares[k] * s.disparities[t[k]];
        }
        if (std::min({shares[0], shares[1], shares[2]}) > -1e-6) nearest = std::max(nearest, sum);
    }
    return nearest;
}

TEST(Hidden, HolesBelongToTheFartherSurface) {
    for (const bool near_is_left : {true, false}) {
        const double from = near_is_left ? 70 : 66;
        const DisparityMesh s = Scene([=](double x, double y) {
                                    const bool hole = x > from && x < from + 4 && y > 50 && y < 54;
                                    return hole ? NAN : (x < 70) == near_is_left ? 40.0 : 20.0;
                                }).open();
        expect_sound(s);
        for (double y = 50.5; y < 54; ++y)
            for (double x = from + 0.5; x < from + 4; ++x)
                if (std::fabs(x - 70) > 1) {
                    EXPECT_NEAR(disparity_at(s, x, y), 20, 0.1) << x << ", " << y;
                }
    }
}

TEST(Hidden, HolesInOneSurfaceCloseAndSpecklesTakeTheNearer) {
    const DisparityMesh hole =
        Scene([](double x, double y) { return std::hypot(x - 71, y - 58) < 3 ? NAN : 20 + 0.1 * x; }).open();
    expect_sound(hole);
    EXPECT_NEAR(area(hole), double(kWidth) * kHeight, 1);
    const DisparityMesh speckle = Scene([](double x, double y) {
                                      const bool wrong = x > 66 && x < 68 && y > 50 && y < 52;
                                      return wrong ? 5.0 : x < 70 ? 40.0 : 20.0;
                                  }).open();
    expect_sound(speckle);
    EXPECT_NEAR(disparity_at(speckle, 67, 51), 40, 0.1);
}

TEST(Hidden, FarSurfacesAreNotRoundedUpToALowStep) {
    // The far surface rises away from the step, within one cell of the lattice; and its mirror image.
    const auto opened = [](bool half_occlusions_right) {
        return Scene([=](double x, double) {
                   const double away = half_occlusions_right ? x - 72 : 72 - x;
                   return away < 0 ? 23.5 : 20 + std::min(3.0, 0.75 * away);
               })
            .open();
    };
    const auto in_front = [](const DisparityMesh& s, double side) {
        double sum = 0;
        for (double y = 20.5; y < 100; ++y) sum += disparity_at(s, 72 + side * 0.5, y) - 20.375;
        return sum / 80;
    };
    const DisparityMesh right = opened(true), left = opened(false);
    expect_sound(right);
    EXPECT_LT(in_front(right, 1), 0.1);
    EXPECT_GT(in_front(left, -1), in_front(right, 1)) << "both cameras see it: the best fit";
}

TEST(Hidden, SilhouettesOfLowHalfOcclusionsLieInsideOfTheNearSurface) {
    const auto mean_silhouette = [](double left, double right) {
        const DisparityMesh s = Scene([=](double x, double) { return x < 66 ? left : right; }).open();
        double sum = 0;
        const std::vector<std::uint32_t> silhouette = silhouette_vertices(s);
        for (const std::uint32_t v : silhouette) sum += s.points[v].x;
        return sum / static_cast<double>(silhouette.size());
    };
    EXPECT_NEAR(mean_silhouette(23, 20), 65.6, 0.05);
    EXPECT_NEAR(mean_silhouette(25, 20), 66, 0.05) << "higher than low";
    EXPECT_NEAR(mean_silhouette(20, 23), 66, 0.05) << "the other camera sees no more there";
}

TEST(Hidden, APixelBetweenTwoHalfOcclusionsIsTheFarthers) {
    // One column, along a slanted silhouette, lies between the near and the far surface.
    const auto column = [](double y) { return 60 + std::floor(y / 7); };
    const auto opened = [&](bool half_occlusions_right, double between, int discontinuity_px) {
        Scene scene([&](double x, double y) {
            const double away = half_occlusions_right ? x - column(y) : column(y) - x;
            return away < 0 ? 50.0 : away < 1 ? between : 42.0;
        });
        scene.config.least_discontinuity_px = discontinuity_px;
        return scene.open();
    };
    const auto mean_there = [&](const DisparityMesh& s, double side) {
        expect_sound(s);
        double sum = 0;
        int count = 0;
        for (double y = 10.5; y < 110; ++y) {
            const double d = disparity_at(s, column(y) + side * 0.5, y);
            sum += d;
            count += d > 0;
        }
        return sum / count;
    };
    EXPECT_NEAR(mean_there(opened(true, 45, 0), 1), 42, 0.1);
    EXPECT_GT(mean_there(opened(false, 45, 0), -1), 44) << "both cameras see it";
    EXPECT_GT(mean_there(opened(true, 49.2, 0), 1), 48) << "too far above the far surface";
    EXPECT_GT(mean_there(opened(true, 45, 4), 1), 43) << "no jump";
}

TEST(Hidden, OnlyOnePixelBetweenHalfOcclusionsIsTheFarthers) {
    const auto settled = [](double before2, double before, double own, double after, double after2) {
        return step::between_half_occlusions(float(before2), float(before), float(own), float(after),
                                             float(after2), 1);
    };
    EXPECT_EQ(settled(50, 50, 45, 42, 42), 42);
    EXPECT_EQ(settled(50, 50, 48.9, 47, 47), 47);
    EXPECT_EQ(settled(0, 50, 45, 42, 0), 42) << "the image's border, or nothing known";
    EXPECT_EQ(settled(50, 50, 49, 42, 42), 49) << "one fall";
    EXPECT_EQ(settled(50, 50, 48, 42, 42), 48) << "a high one";
    EXPECT_EQ(settled(52, 50, 47, 45, 45), 47) << "a slope goes on before";
    EXPECT_EQ(settled(50, 50, 47, 45, 43), 47) << "and behind";
    EXPECT_EQ(settled(50, 50, 47, 0, 0), 47) << "nothing is known behind";
    EXPECT_EQ(settled(42, 42, 47, 50, 50), 47) << "rises";
}

TEST(Hidden, CoveringFartherPixelsCostsMost) {
    EXPECT_DOUBLE_EQ(step::outlier_error(20, 22, 20), 4 * 4);
    EXPECT_DOUBLE_EQ(step::outlier_error(20, 18, 20), 4);
    EXPECT_DOUBLE_EQ(step::outlier_error(20, 20, 20), 0);
    EXPECT_DOUBLE_EQ(step::outlier_error(0, 20, 20), 0.7 * 0.7 * 0.7 * 100) << "a hole";
}

}  // namespace
}  // namespace hexrelief::surface
