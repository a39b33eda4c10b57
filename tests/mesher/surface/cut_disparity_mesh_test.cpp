// Tests the mesh cut along silhouettes, on scenes whose truth is known in closed form.
#include "mesher/surface/cut_disparity_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

#include "mesher/surface/pixels/pixel_surfaces.h"
#include "pipeline/data/error.h"
#include "tests/mesher/surface/made_up_scene.h"

namespace hexrelief::surface {
namespace {

// Checks the silhouettes' edges. The disc's map determines its circle only to half a pixel, and the vertices
// between chords that fit it lie a little outside.
void expect_silhouettes_on_disc(const DisparityMesh& s) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (const Triangle& t : s.triangles)
        for (int k = 0; k < 3; ++k) ++edges[std::minmax(t[k], t[(k + 1) % 3])];
    double sum = 0;
    int count = 0, far = 0;
    for (const auto& [edge, triangles] : edges) {
        const Vec2f &a = s.points[edge.first], &b = s.points[edge.second];
        const auto inside = [](const Vec2f& p) {
            return p.x > 0.01f && p.y > 0.01f && p.x < kWidth - 0.01f && p.y < kHeight - 0.01f;
        };
        if (triangles != 1 || !inside(a) || !inside(b)) continue;
        for (const double t : {0.0, 0.2, 0.4, 0.6, 0.8}) {
            const double off = std::hypot(a.x + t * (b.x - a.x) - 71.3, a.y + t * (b.y - a.y) - 58.6) - 33.4;
            EXPECT_LT(std::fabs(off), 0.55);
            far += std::fabs(off) > 0.5;
            sum += off;
            ++count;
        }
    }
    ASSERT_GT(count, 100);
    EXPECT_LT(far, 0.03 * count);
    EXPECT_LT(std::fabs(sum / count), 0.1) << "rims lie too far in or out";
}

TEST(CutDisparityMesh, IsExactOnSlantedPlanes) {
    const auto planes = {std::array{40.0, 0.0, 0.0}, std::array{20.0, 0.3, 0.1}, std::array{90.0, -0.4, 0.2},
                         std::array{12.0, 0.0, 0.93}, std::array{170.0, -0.9, -0.2}};
    for (const auto& [d, gx, gy] : planes) {
        const auto plane = [d = d, gx = gx, gy = gy](double x, double y) { return d + gx * x + gy * y; };
        const DisparityMesh s = Scene(plane).open();
        expect_sound(s);
        EXPECT_EQ(components(s), 1u) << "a slanted plane is not a jump";
        EXPECT_EQ(s.points, Scene(plane).mesh.positions) << "nothing to align with";
        for (std::size_t i = 0; i < s.points.size(); ++i)
            EXPECT_NEAR(s.disparities[i], plane(s.points[i].x, s.points[i].y), 2e-4);
    }
}

TEST(CutDisparityMesh, SuppressesNoiseAndOutliersOnAPlane) {
    std::uint32_t state = 7;
    const auto random = [&] {
        state = state * 1664525u + 1013904223u;
        return (state >> 8) / double(1 << 24) - 0.5;
    };
    const auto plane = [](double x, double y) { return 30 + 0.2 * x - 0.1 * y; };
    const DisparityMesh s = Scene([&](double x, double y) {
                                const double noise = random();  // +-0.5 px, 0.29 px root mean square
                                return plane(x, y) + (random() > 0.47 ? 15 : noise);
                            }).open();
    expect_sound(s);
    EXPECT_EQ(components(s), 1u) << "specks are no surfaces";
    double squares = 0;
    for (std::size_t i = 0; i < s.points.size(); ++i) {
        const double e = s.disparities[i] - plane(s.points[i].x, s.points[i].y);
        squares += e * e;
    }
    EXPECT_LT(std::sqrt(squares / static_cast<double>(s.points.size())), 0.15);
}

TEST(CutDisparityMesh, CutsADiscFromThePlaneBehind) {
    for (const auto& [near, far] : {std::pair{60.0, 20.0}, std::pair{24.0, 20.0}, std::pair{20.0, 60.0}}) {
        const DisparityMesh s =
            Scene([near = near, far = far](double x, double y) { return disc(x, y, near, far); }).open();
        expect_sound(s);
        EXPECT_EQ(components(s), 2u);
        for (const Triangle& t : s.triangles)
            for (int k = 0; k < 3; ++k)
                EXPECT_NEAR(s.disparities[t[k]], s.disparities[t[0]], 1e-4) << "a triangle spans the step";
        const std::vector<std::uint32_t> silhouette = silhouette_vertices(s);
        std::size_t near_silhouette = 0;
        for (const std::uint32_t v : silhouette) near_silhouette += std::fabs(s.disparities[v] - near) < 0.01;
        expect_silhouettes_on_disc(s);
        EXPECT_EQ(2 * near_silhouette, silhouette.size()) << "both rims have the same vertices";
        EXPECT_GT(near_silhouette, 20u);
        EXPECT_NEAR(area(s), kWidth * kHeight, 1e-2) << "no gap in the image";
    }
}

TEST(CutDisparityMesh, ExtrapolatesEachSideFromItsOwnSurface) {
    const auto near = [](double x, double y) { return 50 + 0.3 * (x - 70) - 0.2 * (y - 60); };
    const auto far = [](double x, double y) { return 15 + 0.02 * x + 0.1 * y; };
    const DisparityMesh s =
        Scene([&](double x, double y) { return x < 68.4 + 0.25 * y ? near(x, y) : far(x, y); }).open();
    expect_sound(s);
    EXPECT_EQ(components(s), 2u);
    for (std::size_t i = 0; i < s.points.size(); ++i) {
        const double a = near(s.points[i].x, s.points[i].y), b = far(s.points[i].x, s.points[i].y);
        EXPECT_LT(std::min(std::fabs(s.disparities[i] - a), std::fabs(s.disparities[i] - b)), 2e-3);
    }
}

TEST(CutDisparityMesh, FindsStepsOfTwoOnMapsOfWholePixels) {
    Scene step([](double x, double y) { return std::floor(20 + 0.02 * y) + (x < 66 ? 2 : 0); });
    EXPECT_EQ(components(step.open()), 2u);
    Scene slope([](double x, double) { return std::floor(20 + 0.9 * x); });
    EXPECT_EQ(components(slope.open()), 1u);
}

TEST(CutDisparityMesh, KeepsAFloorAtAGrazingAngleWhole) {
    for (const double slope : {1.6, 2.3, -3.4}) {
        const auto floor_at = [=](double y) { return std::floor((slope < 0 ? 430 : 20) + slope * y); };
        const DisparityMesh floor = Scene([&](double, double y) { return floor_at(y); }).open();
        expect_sound(floor);
        EXPECT_EQ(components(floor), 1u);
        EXPECT_TRUE(silhouette_vertices(floor).empty());
        const DisparityMesh box =
            Scene([&](double x, double y) {
                return std::fabs(x - 70) < 25 && std::fabs(y - 55) < 20 ? floor_at(75) + 20 : floor_at(y);
            }).open();
        expect_sound(box);
        EXPECT_GE(silhouette_vertices(box).size(), 40u) << "what stands on it is still parted from it";
    }
}

TEST(CutDisparityMesh, KeepsAFloorWithUnevenStepsAndFoldsWhole) {
    // as of a cloth: a slope of 0.5 px a row in whole pixels, in its middle with steps of 3 px, and a fold
    // that hides six rows
    const auto cloth_at = [](double, double y) {
        return 20 + (y < 24 || y >= 84 ? std::floor(0.5 * y) : 3 * std::floor(y / 6));
    };
    EXPECT_EQ(components(Scene(cloth_at).open()), 1u);
    const auto folded_at = [](double, double y) { return 20 + 0.5 * y + (y > 50 ? 3 : 0); };
    EXPECT_EQ(components(Scene(folded_at).open()), 1u);
    const auto parted_at = [](double, double y) { return 20 + 0.5 * y + (y > 50 ? 6 : 0); };
    EXPECT_EQ(components(Scene(parted_at).open()), 2u) << "what hides twelve rows is in front";
    const auto shelf_at = [](double, double y) { return y > 50 ? 23.0 : 20.0; };
    EXPECT_EQ(components(Scene(shelf_at).open()), 2u);
}

TEST(CutDisparityMesh, BridgesWhereAsked) {
    Scene scene([](double x, double y) { return disc(x, y, 60, 20); });
    scene.config.discontinuities = Discontinuities::bridge;
    const DisparityMesh s = scene.open();
    expect_sound(s);
    EXPECT_EQ(components(s), 1u);
    EXPECT_TRUE(silhouette_vertices(s).empty());
    scene.background_px = 30;  // the background is still separated by a silhouette
    const DisparityMesh cut = scene.open();
    expect_sound(cut);
    EXPECT_NEAR(area(cut), 3.14159265 * 33.4 * 33.4, 25);
}

TEST(CutDisparityMesh, LeavesUnknownAndBackgroundOpenAlongCleanSilhouettes) {
    const double kUnknown = std::nan("");
    Scene hole([&](double x, double y) { return disc(x, y, kUnknown, 20); });
    const DisparityMesh s = hole.open();
    expect_sound(s);
    EXPECT_EQ(components(s), 1u);
    const double disc_area = 3.14159265 * 33.4 * 33.4;
    EXPECT_NEAR(area(s), kWidth * kHeight - disc_area, 25);
    expect_silhouettes_on_disc(s);

    Scene shape([](double x, double y) { return disc(x, y, 20, 4); });
    shape.background_px = 5;
    EXPECT_NEAR(area(shape.open()), disc_area, 25);
}

TEST(CutDisparityMesh, KeepsNarrowStripsApart) {
    // A strip of background narrower than the lattice's spacing.
    Scene scene([](double, double y) { return std::fabs(y - 58.2) < 2.6 ? 5.0 : 40.0; });
    scene.background_px = 10;
    const DisparityMesh s = scene.open();
    expect_sound(s);
    EXPECT_EQ(components(s), 2u);
    for (const float d : s.disparities) EXPECT_NEAR(d, 40, 1e-3);
}

TEST(CutDisparityMesh, LetsNoTriangleJoinLeavesThatMeetOrCross) {
    std::uint32_t state = 5;
    const auto random = [&] {
        state = state * 1664525u + 1013904223u;
        return (state >> 8) / double(1 << 24);
    };
    int spanning = 0, behind = 0;
    for (int round = 0; round < 32; ++round) {
        if (round == 16) state = 21;  // leaves in a column, like stairs
        struct Leaf {
            double x, y, along_x, along_y, size, width, disparity;
        };
        std::vector<Leaf> leaves;
        for (int k = 0; k < 14; ++k) {
            const double angle = 6.2831853 * random();
            leaves.push_back({kWidth * random(), kHeight * random(), std::cos(angle), std::sin(angle),
                              20 + 40 * random(), 1 + 6 * random(), 40.0 + 10 * k});
        }
        const Scene scene([&](double x, double y) {
            double d = round % 2 == 0 ? 30 : std::nan("");
            for (const Leaf& l : leaves) {
                const double u = ((x - l.x) * l.along_x + (y - l.y) * l.along_y) / l.size,
                             v = ((y - l.y) * l.along_x - (x - l.x) * l.along_y) / l.width;
                if (u * u + std::fabs(v) < 1) d = l.disparity;
            }
            return d;
        });
        const DisparityMesh s = scene.open();
        expect_sound(s);
        for (const Triangle& t : s.triangles)
            spanning += std::fabs(s.disparities[t[1]] - s.disparities[t[0]]) > 5 ||
                        std::fabs(s.disparities[t[2]] - s.disparities[t[0]]) > 5;
        for (const float d : s.disparities) behind += d < (round % 2 == 0 ? 28 : 38);
    }
    EXPECT_EQ(spanning, 0);
    EXPECT_EQ(behind, 0) << "vertices behind every surface";
}

TEST(CutDisparityMesh, JoinsCutsAcrossAGap) {
    int whole = 0;
    for (int gap = 25; gap < 95; gap += 2) {
        // The step is spread over five pixels for three rows, which therefore have no discontinuity.
        const DisparityMesh s = Scene([=](double x, double y) {
                                    const bool spread = y > gap && y < gap + 3;
                                    return spread ? std::clamp(95 - x, 20.0, 25.0) : x < 72 ? 25.0 : 20.0;
                                }).open();
        expect_sound(s);
        whole += components(s) == 1;
    }
    EXPECT_EQ(whole, 0) << "of 35 sheets held together by an edge within the cut";
}

TEST(CutDisparityMesh, TakesTheGivenDiscontinuity) {
    Scene scene([](double x, double) { return x < 66 ? 26.0 : 20.0; });
    EXPECT_EQ(components(scene.open()), 2u);
    scene.config.least_discontinuity_px = 5.9;
    EXPECT_EQ(components(scene.open()), 2u);
    scene.config.least_discontinuity_px = 6.1;
    EXPECT_EQ(components(scene.open()), 1u);
}

TEST(CutDisparityMesh, EndsACutWhereTheDiscontinuityFades) {
    // A fold: the step shrinks from 30 px at the top to nothing at the bottom.
    const DisparityMesh s =
        Scene([](double x, double y) { return x < 75 ? 20 + 30 * (1 - y / kHeight) : 20; }).open();
    expect_sound(s);
    EXPECT_EQ(components(s), 1u);
    EXPECT_FALSE(silhouette_vertices(s).empty());
    for (const std::uint32_t v : silhouette_vertices(s)) EXPECT_NEAR(s.points[v].x, 75, 0.5);
}

TEST(CutDisparityMesh, StaysSoundOnAdaptedLatticesAndNoise) {
    std::uint32_t state = 99;
    const auto random = [&] {
        state = state * 1664525u + 1013904223u;
        return (state >> 8) / double(1 << 24);
    };
    for (int round = 0; round < 6; ++round) {
        Scene scene([&](double x, double y) {
            const double base = disc(x, y, 50, 10 + 0.1 * x);
            const double r = random();
            return r < 0.02 * round ? std::nan("") : r < 0.04 * round ? base * random() : base;
        });
        scene.background_px = 12;
        DensityMap density{kWidth, kHeight, {}, 12};
        for (const float d : scene.map.values)
            density.values.push_back(std::isfinite(d) && d >= 12 ? d * d * d / 125000 : 0);
        scene.mesh = mesher::solve_mesh(density, {}, 2, {});
        const DisparityMesh s = scene.open();
        expect_sound(s);
        for (const float d : s.disparities) {
            EXPECT_GE(d, 6) << "far behind every pixel";
            EXPECT_LE(d, 60) << "far in front of every pixel";
        }
    }
}

TEST(CutDisparityMesh, SameBytesForAnyNumberOfThreads) {
    const Scene scene([](double x, double y) {
        return disc(x, y, 50 + 3 * std::sin(x * 0.2) * std::cos(y * 0.3), 10 + 0.1 * x);
    });
    const DisparityMesh one = scene.open(1);
    for (const int threads : {2, 3, 7}) {
        const DisparityMesh many = scene.open(threads);
        ASSERT_EQ(many.points, one.points);
        EXPECT_EQ(many.triangles, one.triangles);
        ASSERT_EQ(many.disparities.size(), one.disparities.size());
        EXPECT_EQ(std::memcmp(many.disparities.data(), one.disparities.data(), 4 * one.disparities.size()),
                  0);
    }
}

TEST(CutDisparityMesh, RefusesWhatDoesNotFit) {
    Scene scene([](double, double) { return 20.0; });
    scene.mesh.positions.pop_back();
    EXPECT_THROW(scene.open(), Error);
    Scene empty([](double, double) { return 20.0; });
    empty.map = {};
    EXPECT_THROW(empty.open(), Error);
    EXPECT_TRUE(Scene([](double, double) { return std::nan(""); }).open().triangles.empty());
}

}  // namespace
}  // namespace hexrelief::surface
