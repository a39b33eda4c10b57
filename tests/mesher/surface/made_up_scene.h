// Scenes for the mesh whose truth is known in closed form, and checks that every mesh must pass.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include "mesher/mesher.h"
#include "mesher/surface/cut_disparity_mesh.h"
#include "tests/mesher/regular_lattice.h"

namespace hexrelief::surface {

inline constexpr int kWidth = 150, kHeight = 120;
inline constexpr float kNothing = kUnknownDisparity;

using DisparityAt = std::function<double(double, double)>;  // at a pixel's centre; NaN = unknown

// Moves the border of the regular lattice onto the image's border.
inline HexMesh2D covering(HexMesh2D mesh) {
    for (int row = 0; row < mesh.rows; ++row)
        for (int column = 0; column < mesh.columns; ++column) {
            Vec2f& p = mesh.positions[mesh.index(column, row)];
            if (column == 0) p.x = 0;
            if (column + 1 == mesh.columns) p.x = kWidth;
            if (row == 0) p.y = 0;
            if (row + 1 == mesh.rows) p.y = kHeight;
        }
    return mesh;
}

struct Scene {
    DisparityMap map{kWidth, kHeight, {}};
    HexMesh2D mesh = covering(mesher::regular_lattice(kWidth, kHeight, 6));
    float background_px = 0;
    SurfaceConfig config;

    explicit Scene(const DisparityAt& disparity) {
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kWidth; ++x) {
                const double d = disparity(x + 0.5, y + 0.5);
                map.values.push_back(std::isnan(d) ? kNothing : static_cast<float>(d));
            }
    }
    DisparityMesh open(int threads = 2) const {
        return cut_disparity_mesh({&mesh, &map, background_px}, config, threads);
    }
};

inline double disc(double x, double y, double near, double far) {
    return std::hypot(x - 71.3, y - 58.6) < 33.4 ? near : far;
}

inline double twice_area(const DisparityMesh& s, const Triangle& t) {
    const Vec2f &a = s.points[t[0]], &b = s.points[t[1]], &c = s.points[t[2]];
    return (double(b.x) - a.x) * (double(c.y) - a.y) - (double(b.y) - a.y) * (double(c.x) - a.x);
}

// Returns, for each vertex, the number of fans of triangles that are connected through edges at it.
inline std::vector<int> count_fans(const DisparityMesh& s) {
    std::vector<std::vector<std::set<std::uint32_t>>> fans(s.points.size());  // neighbours of each vertex
    for (const Triangle& t : s.triangles)
        for (int k = 0; k < 3; ++k) {
            std::set<std::uint32_t> own{t[(k + 1) % 3], t[(k + 2) % 3]};
            auto& at = fans[t[k]];
            std::erase_if(at, [&](const std::set<std::uint32_t>& other) {
                const bool joined = other.contains(t[(k + 1) % 3]) || other.contains(t[(k + 2) % 3]);
                if (joined) own.insert(other.begin(), other.end());
                return joined;
            });
            at.push_back(own);
        }
    std::vector<int> counts;
    for (const auto& at : fans) counts.push_back(static_cast<int>(at.size()));
    return counts;
}

// Checks for positive areas, every edge at most once in each direction, every vertex used, all numbers
// finite, and one fan at each vertex.
inline void expect_sound(const DisparityMesh& s) {
    ASSERT_EQ(s.points.size(), s.disparities.size());
    std::set<std::pair<std::uint32_t, std::uint32_t>> halfedges;
    std::set<std::uint32_t> used;
    for (const Triangle& t : s.triangles) {
        EXPECT_GT(twice_area(s, t), 1e-4);
        for (int k = 0; k < 3; ++k) {
            ASSERT_LT(t[k], s.points.size());
            used.insert(t[k]);
            EXPECT_TRUE(halfedges.insert({t[k], t[(k + 1) % 3]}).second) << "twice in one direction";
        }
    }
    EXPECT_EQ(used.size(), s.points.size()) << "vertices without a triangle";
    EXPECT_TRUE(s.has_one_fan_per_vertex);
    for (const int fans : count_fans(s)) EXPECT_EQ(fans, 1);
    for (const float d : s.disparities) EXPECT_TRUE(std::isfinite(d) && d > 0) << d;
    for (const Vec2f& p : s.points)
        EXPECT_TRUE(p.x >= 0 && p.y >= 0 && p.x <= kWidth && p.y <= kHeight) << p.x << " " << p.y;
}

inline double area(const DisparityMesh& s) {
    double sum = 0;
    for (const Triangle& t : s.triangles) sum += twice_area(s, t) / 2;
    return sum;
}

inline std::size_t components(const DisparityMesh& s) {
    std::vector<std::uint32_t> parents(s.points.size());
    for (std::uint32_t i = 0; i < parents.size(); ++i) parents[i] = i;
    const auto root = [&](std::uint32_t i) {
        while (parents[i] != i) i = parents[i];
        return i;
    };
    for (const Triangle& t : s.triangles)
        for (const std::uint32_t v : t) parents[root(v)] = root(t[0]);
    std::set<std::uint32_t> roots;
    for (std::uint32_t i = 0; i < parents.size(); ++i) roots.insert(root(i));
    return roots.size();
}

// Returns the ends of edges with a single triangle, away from the image's border.
inline std::vector<std::uint32_t> silhouette_vertices(const DisparityMesh& s) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (const Triangle& t : s.triangles)
        for (int k = 0; k < 3; ++k) ++edges[std::minmax(t[k], t[(k + 1) % 3])];
    std::set<std::uint32_t> ends;
    const auto inside = [&](std::uint32_t i) {
        const Vec2f& p = s.points[i];
        return p.x > 0.01f && p.y > 0.01f && p.x < kWidth - 0.01f && p.y < kHeight - 0.01f;
    };
    for (const auto& [edge, count] : edges)
        for (const std::uint32_t v : {edge.first, edge.second})
            if (count == 1 && inside(v)) ends.insert(v);
    return {ends.begin(), ends.end()};
}

}  // namespace hexrelief::surface
