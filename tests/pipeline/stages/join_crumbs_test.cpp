#include "pipeline/stages/join_crumbs.h"

#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <set>

namespace hexrelief::stages {
namespace {

constexpr int kSide = 12;  // squares of 2 x 2 px, two triangles each

// A mesh of squares that are joined where they have one disparity.
DisparityMesh mesh_of(const std::function<float(int, int)>& disparity) {
    DisparityMesh mesh;
    std::map<std::pair<int, float>, std::uint32_t> vertices;  // by the place and the disparity
    const auto each_corner = [](const auto& visit) {
        for (int y = 0; y < kSide; ++y)
            for (int x = 0; x < kSide; ++x)
                for (const auto& [v, u] : {std::pair{y, x}, {y, x + 1}, {y + 1, x}, {y + 1, x + 1}})
                    visit(x, y, v * (kSide + 1) + u);
    };
    each_corner([&](int x, int y, int place) { vertices[{place, disparity(x, y)}] = 0; });
    for (auto& [key, vertex] : vertices) {
        vertex = static_cast<std::uint32_t>(mesh.points.size());
        mesh.points.push_back({2.0f * static_cast<float>(key.first % (kSide + 1)),
                               2.0f * static_cast<float>(key.first / (kSide + 1))});
        mesh.disparities.push_back(key.second);
    }
    std::vector<std::uint32_t> corners;
    each_corner([&](int x, int y, int place) { corners.push_back(vertices[{place, disparity(x, y)}]); });
    for (std::size_t i = 0; i < corners.size(); i += 4) {
        mesh.triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
        mesh.triangles.push_back({corners[i + 1], corners[i + 3], corners[i + 2]});
    }
    mesh.has_one_fan_per_vertex = true;
    return mesh;
}

// Returns the disparities of the corners of a square.
std::set<float> disparities_at(const DisparityMesh& mesh, int x, int y) {
    std::set<float> found;
    const std::size_t first = 2 * (static_cast<std::size_t>(y) * kSide + x);
    for (std::size_t i = first; i < first + 2; ++i)
        for (const std::uint32_t corner : mesh.triangles[i]) found.insert(mesh.disparities[corner]);
    return found;
}

TEST(JoinCrumbs, JoinsTheOneThatCostsLittle) {
    const auto cut = mesh_of([](int x, int y) {
        return y == 2 && x >= 2 && x < 4 ? 11.5f : y == 8 && x == 8 ? 14.0f : 10.0f;
    });
    DisparityMesh mesh = cut;
    join_crumbs(mesh, 2 * 19);  // two squares of 4 px2 at 1.5 px cost 18, one at 4 px costs 64
    EXPECT_EQ(mesh.points.size(), cut.points.size());
    EXPECT_FALSE(mesh.has_one_fan_per_vertex);
    EXPECT_EQ(disparities_at(mesh, 2, 2), std::set<float>{10});
    EXPECT_EQ(disparities_at(mesh, 3, 2), std::set<float>{10});
    EXPECT_EQ(disparities_at(mesh, 8, 8), std::set<float>{14});
    mesh = cut;
    join_crumbs(mesh, 2 * 17);
    EXPECT_EQ(mesh.triangles, cut.triangles);
    EXPECT_TRUE(mesh.has_one_fan_per_vertex);
}

TEST(JoinCrumbs, TakesTheSideThatCostsLessAndKeepsTheOther) {
    DisparityMesh mesh = mesh_of([](int x, int y) {
        return x < 6 ? 10.0f : x == 6 && y == 5 ? 11.0f : 13.0f;
    });
    join_crumbs(mesh, 2 * 4);
    EXPECT_EQ(disparities_at(mesh, 6, 5), (std::set<float>{10, 11})) << "open on the far side";
    EXPECT_EQ(disparities_at(mesh, 5, 5), std::set<float>{10});
    EXPECT_EQ(disparities_at(mesh, 7, 5), std::set<float>{13});
}

TEST(JoinCrumbs, JoinsWhatIsBesideAJoinedOne) {
    DisparityMesh mesh = mesh_of([](int x, int y) {
        return x > 1 || y > 1 ? 10.0f : x + y > 0 ? 11.0f : 12.0f;
    });
    join_crumbs(mesh, 2 * 12);
    EXPECT_EQ(disparities_at(mesh, 1, 1), (std::set<float>{10, 11}));
    EXPECT_EQ(disparities_at(mesh, 0, 0), (std::set<float>{11, 12})) << "touches nothing else";
}

TEST(JoinCrumbs, JoinsTinyOnesWhateverItCosts) {
    const auto cut = mesh_of([](int x, int y) {
        return y == 2 && x >= 2 && x < 4 ? 90.0f : (y == 8 && x == 8) || x + y == 0 ? 50.0f : 10.0f;
    });
    DisparityMesh mesh = cut;
    join_crumbs(mesh, 1, 8);  // a square has 4 px, two have 8
    EXPECT_EQ(disparities_at(mesh, 2, 2), std::set<float>{90});
    EXPECT_EQ(disparities_at(mesh, 8, 8), std::set<float>{10});
    EXPECT_EQ(disparities_at(mesh, 0, 0), std::set<float>{10}) << "in the mesh's corner";
}

TEST(JoinCrumbs, LargeComponentsStay) {
    const auto halves = mesh_of([](int x, int) { return x < 6 ? 10.0f : 10.1f; });
    DisparityMesh mesh = halves;
    join_crumbs(mesh, 1000);
    EXPECT_EQ(mesh.triangles, halves.triangles);
    const auto crumbs = mesh_of([](int x, int y) { return y == 6 && (x == 2 || x == 8) ? 11.0f : 10.0f; });
    mesh = crumbs;
    const std::uint32_t held = mesh.triangles[2 * (6 * kSide + 2)][0];
    join_crumbs(mesh, 1000, 0, {held});
    EXPECT_EQ(disparities_at(mesh, 2, 6), std::set<float>{11}) << "counts as large";
    EXPECT_EQ(disparities_at(mesh, 8, 6), std::set<float>{10});
    const auto crumb_alone = mesh_of([](int, int) { return 10.0f; });
    mesh = {crumb_alone.points, crumb_alone.disparities, {crumb_alone.triangles[0]}, true};
    join_crumbs(mesh, 1000);
    EXPECT_EQ(mesh.triangles.size(), 1u);
}

}  // namespace
}  // namespace hexrelief::stages
