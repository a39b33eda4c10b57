#include "pipeline/stages/surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <set>

#include "pipeline/stages/surface_topology.h"
#include "tests/expect_error.h"

namespace hexrelief::stages {
namespace {

constexpr int kColumns = 21, kRows = 17;
constexpr double kSpacing_px = 6;
constexpr int kWidth = 132, kHeight = 102;

using DisparityAt = std::function<double(double, double)>;

// A lattice over an image whose disparity is a function of the image point; NaN = no surface.
struct Example {
    HexMesh2D mesh;
    std::vector<float> disparities;
    Calibration calibration{500, 70, 48, 0.1, 0, true, kWidth, kHeight};
    int min_component = 0;

    explicit Example(const DisparityAt& disparity) {
        mesh.columns = kColumns;
        mesh.rows = kRows;
        const auto known = [&](double x, double y) {
            const double d = disparity(x, y);
            return std::isnan(d) ? std::numeric_limits<float>::infinity() : static_cast<float>(d);
        };
        for (int row = 0; row < kRows; ++row)
            for (int column = 0; column < kColumns; ++column) {
                const double x = (column + 0.25 + 0.5 * (row & 1)) * kSpacing_px,
                             y = (row + 0.5) * kSpacing_px;
                mesh.positions.push_back({static_cast<float>(x), static_cast<float>(y)});
                disparities.push_back(known(x, y));
            }
    }
    // Returns all triangles whose vertices have a disparity.
    DisparityMesh cut_mesh() const {
        DisparityMesh cut_mesh{mesh.positions, disparities, {}, {}};
        for (int row = 0; row + 1 < kRows; ++row)
            for (int column = 0; column + 1 < kColumns; ++column)
                for (const Triangle& t : quad_triangles(kColumns, column, row))
                    if (std::all_of(t.begin(), t.end(),
                                    [&](auto i) { return std::isfinite(disparities[i]); }))
                        cut_mesh.triangles.push_back(t);
        return cut_mesh;
    }
    SurfaceMesh build() const {
        return build_surface(cut_mesh(), kWidth, kHeight, calibration, min_component);
    }
};

void expect_sound(const SurfaceMesh& s) {
    const std::size_t count = s.positions.size();
    ASSERT_EQ(s.normals.size(), count);
    ASSERT_EQ(s.texcoords.size(), count);
    ASSERT_EQ(s.image_points.size(), count);
    ASSERT_EQ(s.disparities.size(), count);
    std::set<std::pair<std::uint32_t, std::uint32_t>> halfedges;
    std::set<std::uint32_t> used;
    for (const Triangle& t : s.triangles) {
        double image_area = 0;
        for (int k = 0; k < 3; ++k) {
            ASSERT_LT(t[k], count);
            used.insert(t[k]);
            EXPECT_TRUE(halfedges.insert({t[k], t[(k + 1) % 3]}).second)
                << "an edge runs twice in one direction";
            const Vec3f &p = s.positions[t[k]], &q = s.positions[t[(k + 1) % 3]];
            image_area += double(p.x / p.z) * (q.y / q.z) - double(q.x / q.z) * (p.y / p.z);
        }
        EXPECT_GT(image_area, 0)
            << "clockwise as the camera sees it";  // x/z and y/z both change sign, so the area keeps its sign
    }
    EXPECT_EQ(used.size(), count) << "isolated vertices";
    for (std::size_t i = 0; i < count; ++i) {
        const Vec3f &n = s.normals[i], &p = s.positions[i];
        EXPECT_NEAR(n.x * n.x + n.y * n.y + n.z * n.z, 1, 1e-5);
        EXPECT_LT(n.x * p.x + n.y * p.y + n.z * p.z, 0) << "a normal that looks away from the camera";
    }
}

TEST(Surface, ReproducesAPlane) {
    // The plane Z = 2 + 0.3 X - 0.5 Y (Y down) has the disparity f B (1 - 0.3 u' - -0.5 v') / 2 in normalised
    // coordinates.
    const auto plane = [](double u, double v) {
        return 500 * 0.1 * (1 - 0.3 * (u - 70) / 500 + 0.5 * (v - 48) / 500) / 2;
    };
    const SurfaceMesh s = Example(plane).build();
    expect_sound(s);
    EXPECT_EQ(s.positions.size(), std::size_t{kColumns} * kRows);
    EXPECT_EQ(s.triangles.size(), std::size_t{2} * (kColumns - 1) * (kRows - 1));
    EXPECT_EQ(count_topology(s).components, 1);
    EXPECT_EQ(count_topology(s).boundary_loops, 1);
    EXPECT_TRUE(s.metric);
    const double scale = std::sqrt(1 + 0.3 * 0.3 + 0.5 * 0.5);
    for (std::size_t i = 0; i < s.positions.size(); ++i) {
        const Vec3f &p = s.positions[i], &n = s.normals[i];
        EXPECT_NEAR(-p.z, 2 + 0.3 * p.x - 0.5 * -p.y, 1e-5);
        EXPECT_NEAR(n.x, 0.3 / scale, 1e-3);
        EXPECT_NEAR(n.y, 0.5 / scale, 1e-3);
        EXPECT_NEAR(n.z, 1 / scale, 1e-3);
        EXPECT_NEAR(s.texcoords[i].x * kWidth, s.image_points[i].x, 0.05);
        EXPECT_NEAR(s.texcoords[i].y * kHeight, s.image_points[i].y, 0.05);
        EXPECT_NEAR(s.image_points[i].x, 70 + 500 * p.x / -p.z, 1e-3);
        EXPECT_NEAR(s.image_points[i].y, 48 - 500 * p.y / -p.z, 1e-3);
    }
}

// Compares with sums of unit normals times angles, with angles from the C library.
// The mean square of how far, in px, the picture's points are drawn from where they were seen, if vertices
// have these places in the picture.
double drawn_error(const SurfaceMesh& s, const std::function<std::array<double, 2>(std::uint32_t)>& place) {
    double sum = 0;
    int count = 0;
    for (const Triangle& t : s.triangles)
        for (int i = 0; i <= 6; ++i)
            for (int j = 0; i + j <= 6; ++j, ++count) {
                const double shares[3] = {i / 6.0, j / 6.0, (6 - i - j) / 6.0};
                double depths = 0, drawn[2] = {}, seen[2] = {};
                for (int k = 0; k < 3; ++k) depths += shares[k] / s.positions[t[k]].z;
                for (int k = 0; k < 3; ++k) {
                    const double weight = shares[k] / s.positions[t[k]].z / depths;
                    const auto [x, y] = place(t[k]);
                    drawn[0] += weight * x;
                    drawn[1] += weight * y;
                    seen[0] += shares[k] * s.image_points[t[k]].x;
                    seen[1] += shares[k] * s.image_points[t[k]].y;
                }
                sum += std::pow(drawn[0] - seen[0], 2) + std::pow(drawn[1] - seen[1], 2);
            }
    return sum / count;
}

TEST(Surface, ShowsThePictureWhereItWasSeen) {
    const SurfaceMesh s = Example([](double x, double y) { return 10 + 0.4 * x + 0.2 * y; }).build();
    const double plain = drawn_error(s, [&](std::uint32_t i) {
        return std::array<double, 2>{s.image_points[i].x, s.image_points[i].y};
    });
    const double drawn = drawn_error(s, [&](std::uint32_t i) {
        return std::array<double, 2>{s.texcoords[i].x * kWidth, s.texcoords[i].y * kHeight};
    });
    EXPECT_GT(plain, 1e-4);
    EXPECT_LT(drawn, 0.5 * plain);
    for (std::size_t i = 0; i < s.positions.size(); ++i) {
        EXPECT_LE(std::abs(s.texcoords[i].x * kWidth - s.image_points[i].x), 0.501);
        EXPECT_LE(std::abs(s.texcoords[i].y * kHeight - s.image_points[i].y), 0.501);
    }
}

TEST(Surface, WeighsNormalsByAngles) {
    std::uint32_t state = 7;
    Example e([&](double x, double y) {
        state = state * 1664525u + 1013904223u;
        return 20 + 4 * std::sin(x / 15) + y / 30 + (state >> 16) % 1000 * 0.002;
    });
    for (Vec2f& p : e.mesh.positions) {
        state = state * 1664525u + 1013904223u;
        p.x += static_cast<float>((state >> 24) / 256.0 * 2.4 - 1.2);
        p.y += static_cast<float>((state >> 16 & 255) / 256.0 * 2.4 - 1.2);
    }
    const SurfaceMesh s = e.build();
    expect_sound(s);
    const auto minus = [](const Vec3f& a, const Vec3f& b) {
        return std::array<double, 3>{double(a.x) - b.x, double(a.y) - b.y, double(a.z) - b.z};
    };
    const auto dot = [](const auto& a, const auto& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
    std::vector<std::array<double, 3>> sums(s.positions.size(), {0, 0, 0});
    for (const Triangle& t : s.triangles)
        for (int k = 0; k < 3; ++k) {
            const auto u = minus(s.positions[t[(k + 1) % 3]], s.positions[t[k]]),
                       v = minus(s.positions[t[(k + 2) % 3]], s.positions[t[k]]);
            const std::array<double, 3> n{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                                          u[0] * v[1] - u[1] * v[0]};
            const double angle = std::acos(dot(u, v) / std::sqrt(dot(u, u) * dot(v, v)));
            for (int i = 0; i < 3; ++i) sums[t[k]][i] += angle * n[i] / std::sqrt(dot(n, n));
        }
    for (std::size_t i = 0; i < sums.size(); ++i) {
        const double size = std::sqrt(dot(sums[i], sums[i]));
        EXPECT_NEAR(s.normals[i].x, sums[i][0] / size, 2e-5);
        EXPECT_NEAR(s.normals[i].y, sums[i][1] / size, 2e-5);
        EXPECT_NEAR(s.normals[i].z, sums[i][2] / size, 2e-5);
    }
}

TEST(Surface, TakesDoffsIntoAccount) {
    Example e([](double, double) { return 5.0; });
    e.calibration.doffs_px = 20;
    for (const Vec3f& p : e.build().positions) EXPECT_FLOAT_EQ(p.z, -500 * 0.1f / 25);
}

TEST(Surface, WorksWithoutMetres) {
    Example e([](double, double) { return 5.0; });
    e.calibration.metric = false;
    const SurfaceMesh s = e.build();
    EXPECT_FALSE(s.metric);
    expect_sound(s);
}

TEST(Surface, LeavesHolesOpen) {
    const SurfaceMesh s = Example([](double x, double y) {
                              return std::hypot(x - 65, y - 50) < 20 ? std::nan("") : 20.0;
                          }).build();
    expect_sound(s);
    EXPECT_EQ(count_topology(s).components, 1);
    EXPECT_EQ(count_topology(s).boundary_loops, 2);
    EXPECT_LT(s.positions.size(), std::size_t{kColumns} * kRows);
}

TEST(Surface, DropsVerticesThatCannotBePlaced) {
    Example e([](double x, double) { return x < 66 ? 15.0 : 3.0; });
    e.calibration.doffs_px = -3;
    const SurfaceMesh s = e.build();
    for (const float d : s.disparities) EXPECT_EQ(d, 15);
    for (const Vec3f& p : s.positions)
        EXPECT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
}

TEST(Surface, DropsInvertedAndDegenerateTriangles) {
    Example e([](double, double) { return 20.0; });
    const std::size_t all = e.build().triangles.size();
    e.mesh.positions[e.mesh.index(10, 8)] = e.mesh.positions[e.mesh.index(11, 8)];
    const SurfaceMesh flat = e.build();
    EXPECT_EQ(flat.triangles.size(), all - 2);  // the two on the edge that has no length
    expect_sound(flat);
    e.mesh.positions[e.mesh.index(10, 8)].x += 4;  // beyond its neighbour
    const SurfaceMesh folded = e.build();
    EXPECT_LT(folded.triangles.size(), all);
    expect_sound(folded);
}

TEST(Surface, DropsSmallComponents) {
    Example e(
        [](double x, double y) { return std::hypot(x - 100, y - 50) < 11 || x < 60 ? 20.0 : std::nan(""); });
    e.min_component = 0;
    const SurfaceMesh both = e.build();
    EXPECT_EQ(count_topology(both).components, 2);
    e.min_component = 30;
    const SurfaceMesh one = e.build();
    expect_sound(one);
    EXPECT_EQ(count_topology(one).components, 1);
    EXPECT_LT(one.triangles.size(), both.triangles.size());
    e.min_component = 100000;
    EXPECT_CONTAINS(test::error_of([&] { e.build(); }), "min_component");
}

TEST(Surface, SplitsVerticesWhereTwoFansTouch) {
    // Two opposite sectors around one vertex: without splitting the vertex, OpenMesh refuses faces there.
    Example e([](double, double) { return 20.0; });
    e.min_component = 0;
    const Vec2f centre = e.mesh.at(10, 8);
    for (std::size_t i = 0; i < e.disparities.size(); ++i) {
        const Vec2f& p = e.mesh.positions[i];
        const bool sector = std::abs(p.y - centre.y) <= 0.5f * std::abs(p.x - centre.x);
        if (!sector && i != e.mesh.index(10, 8)) e.disparities[i] = std::numeric_limits<float>::infinity();
    }
    // The left and right neighbours belong to the surface, those above and below do not; a fan needs two
    // vertices on each side.
    for (const int row : {7, 9}) {
        e.disparities[e.mesh.index(9, row)] = 20;  // left sector
        e.disparities[e.mesh.index(10, row)] = std::numeric_limits<float>::infinity();
    }
    e.disparities[e.mesh.index(11, 8)] = 20;
    e.disparities[e.mesh.index(10, 7)] = 20;
    e.disparities[e.mesh.index(9, 7)] = std::numeric_limits<float>::infinity();
    const SurfaceMesh s = e.build();
    expect_sound(s);
    std::vector<std::size_t> at_centre;
    for (std::size_t i = 0; i < s.image_points.size(); ++i)
        if (s.image_points[i] == centre) at_centre.push_back(i);
    ASSERT_EQ(at_centre.size(), 2u);
    EXPECT_EQ(at_centre[0] + 1, at_centre[1]) << "copies lie side by side";
    EXPECT_EQ(s.positions[at_centre[0]], s.positions[at_centre[1]]);
}

TEST(Surface, StaysManifoldOnRandomHoles) {
    Example e([](double, double) { return 20.0; });
    e.min_component = 0;
    std::uint32_t state = 12345;
    for (int round = 0; round < 50; ++round) {
        for (float& d : e.disparities) {
            state = state * 1664525u + 1013904223u;
            d = (state >> 16) % 3 == 0 ? std::numeric_limits<float>::infinity() : 20.0f;
        }
        std::size_t expected = 0;
        for (int row = 0; row + 1 < kRows; ++row)
            for (int column = 0; column + 1 < kColumns; ++column)
                for (const Triangle& t : quad_triangles(kColumns, column, row))
                    expected +=
                        std::all_of(t.begin(), t.end(), [&](auto i) { return e.disparities[i] == 20; });
        const SurfaceMesh s = e.build();
        expect_sound(s);
        EXPECT_EQ(s.triangles.size(), expected) << "faces were lost";
        EXPECT_GE(count_topology(s).boundary_loops, count_topology(s).components);
        // Vertices are in the lattice's order: row by row, left to right within a row.
        for (std::size_t i = 1; i < s.image_points.size(); ++i) {
            const Vec2f &a = s.image_points[i - 1], &b = s.image_points[i];
            EXPECT_TRUE(a.y < b.y || (a.y == b.y && a.x <= b.x));
        }
    }
}

TEST(Surface, IsTheSameWhereItIsKnownThatEachVertexHoldsOneFan) {
    const Example e([](double x, double y) { return 20 + 0.02 * x + 0.01 * y; });
    DisparityMesh cut_mesh = e.cut_mesh();
    const auto build = [&] {
        return build_surface(cut_mesh, kWidth, kHeight, e.calibration, e.min_component);
    };
    const SurfaceMesh unknown = build();
    cut_mesh.has_one_fan_per_vertex = true;
    const SurfaceMesh known = build();
    EXPECT_EQ(known.triangles, unknown.triangles);
    EXPECT_EQ(known.positions, unknown.positions);
    EXPECT_EQ(known.image_points, unknown.image_points);
    cut_mesh.disparities[kColumns + 1] = std::numeric_limits<float>::infinity();  // its triangles are dropped
    cut_mesh.has_one_fan_per_vertex = false;
    const SurfaceMesh torn = build();
    EXPECT_LT(torn.triangles.size(), unknown.triangles.size());
    cut_mesh.has_one_fan_per_vertex = true;
    EXPECT_EQ(build().triangles, torn.triangles);
}

TEST(Surface, RefusesImpossibleInput) {
    Example e([](double, double) { return 20.0; });
    e.calibration.focal_px = 0;
    EXPECT_CONTAINS(test::error_of([&] { e.build(); }), "focal_px");
    e.calibration.focal_px = 500;
    e.calibration.baseline_m = -1;
    EXPECT_CONTAINS(test::error_of([&] { e.build(); }), "baseline_m");
    e.calibration.baseline_m = 1;
    DisparityMesh odd = e.cut_mesh();
    odd.disparities.pop_back();
    EXPECT_CONTAINS(
        test::error_of([&] { build_surface(odd, kWidth, kHeight, e.calibration, e.min_component); }),
        "disparities");
    Example nothing([](double, double) { return std::nan(""); });
    EXPECT_CONTAINS(test::error_of([&] { nothing.build(); }), "no triangle is left");
}

// Returns the mean angle, degrees, between normals of a plane's surface with and without noise, at the
// vertices that lie at least `margin_px` from the fold.
double mean_error(const SurfaceMesh& mesh, const SurfaceMesh& exact, double fold_px, double margin_px) {
    double sum = 0;
    int count = 0;
    for (std::size_t i = 0; i < mesh.normals.size(); ++i) {
        if (std::abs(mesh.image_points[i].x - fold_px) < margin_px) continue;
        const Vec3f &n = mesh.normals[i], &m = exact.normals[i];
        sum += std::acos(std::min(1.0f, n.x * m.x + n.y * m.y + n.z * m.z)) * 180 / std::numbers::pi;
        ++count;
    }
    return sum / count;
}

TEST(SmoothNormals, NoiseGoesAndFoldsStay) {
    constexpr double kFold_px = 66;
    const auto roof = [](double x, double y) { return 40 - 0.2 * std::abs(x - kFold_px) + 0.05 * y; };
    // An even spread of -0.1 to 0.1 px.
    const auto noise = [](double x, double y) {
        const double turns = 0.618 * x + 0.755 * y + 0.1 * x * y;
        return 0.2 * (turns - std::floor(turns)) - 0.1;
    };
    const Example exact(roof);
    const Example rough([&](double x, double y) { return roof(x, y) + noise(x, y); });
    const SurfaceMesh wanted = exact.build(), before = rough.build();
    SurfaceMesh after = before, still = wanted;
    smooth_normals(after, rough.calibration);
    EXPECT_EQ(after.positions, before.positions);
    EXPECT_LT(mean_error(after, wanted, kFold_px, 0), 0.5 * mean_error(before, wanted, kFold_px, 0));
    EXPECT_LT(mean_error(after, wanted, kFold_px, 12), 0.4 * mean_error(before, wanted, kFold_px, 12));
    smooth_normals(still, exact.calibration);
    EXPECT_LT(mean_error(still, wanted, kFold_px, 0), 0.1) << "without noise";

    SurfaceMesh of_steps = before, of_fine_steps = before;
    smooth_normals(of_steps, rough.calibration, 1);
    EXPECT_LT(mean_error(of_steps, wanted, kFold_px, 0), 0.6 * mean_error(before, wanted, kFold_px, 0));
    smooth_normals(of_fine_steps, rough.calibration, 0.01);
    EXPECT_GT(mean_error(of_fine_steps, wanted, kFold_px, 0), 0.9 * mean_error(before, wanted, kFold_px, 0));
}

TEST(SmoothNormals, NormalsThatMismatchesTurnAreReplaced) {
    Example rough([](double x, double y) { return 40 - 0.1 * x + 0.05 * y; });
    const SurfaceMesh wanted = rough.build();
    for (std::size_t i = 30; i < rough.disparities.size(); i += 67) rough.disparities[i] += 2;
    const SurfaceMesh before = rough.build();
    SurfaceMesh after = before;
    smooth_normals(after, rough.calibration);
    EXPECT_LT(mean_error(after, wanted, 0, 0), 0.1 * mean_error(before, wanted, 0, 0));
}

}  // namespace
}  // namespace hexrelief::stages
