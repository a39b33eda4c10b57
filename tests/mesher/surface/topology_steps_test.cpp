// Tests the steps of surface/topology against their headers' contracts, computed in another way.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <set>
#include <vector>

#include "mesher/surface/topology/cut_vertices_step.h"
#include "mesher/surface/topology/label_triangles_step.h"
#include "mesher/surface/topology/rasterize.h"
#include "mesher/surface/topology/rasterize_step.h"
#include "mesher/surface/topology/snap_vertices_step.h"
#include "mesher/surface/topology/split_triangles_step.h"

namespace hexrelief::surface {
namespace {

double cross(const Vec2f& a, const Vec2f& b, double x, double y) {
    return (double(b.x) - a.x) * (y - a.y) - (double(b.y) - a.y) * (x - a.x);
}

TEST(Rasterize, RunsAreThePixelsWhoseCentresLieInside) {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> at(-2, 26);
    for (int i = 0; i < 2000; ++i) {
        Vec2f a{at(random), at(random)}, b{at(random), at(random)}, c{at(random), at(random)};
        if (cross(a, b, c.x, c.y) < 0) std::swap(b, c);
        std::set<std::pair<int, int>> found, expected;
        each_run(24, 24, a, b, c, [&](const PixelRun& run) {
            for (int x = run.first; x < run.end; ++x) found.emplace(x, run.y);
        });
        for (int y = 0; y < 24; ++y)
            for (int x = 0; x < 24; ++x)
                if (cross(a, b, x + 0.5, y + 0.5) > 0 && cross(b, c, x + 0.5, y + 0.5) > 0 &&
                    cross(c, a, x + 0.5, y + 0.5) > 0)
                    expected.emplace(x, y);
        EXPECT_EQ(found, expected);
    }
}

// Compares several rows at a time with row by row, also on a raster of quarter pixels, where sides run
// through pixel centres; inverted triangles have no pixels.
TEST(Rasterize, FindsTheSameRunsSeveralRowsAtATime) {
    std::mt19937 random(4);
    std::uniform_real_distribution<float> at(-2, 42);
    std::vector<PixelRun> buffer;
    for (int i = 0; i < 20000; ++i) {
        const float raster = i % 3 == 0 ? 4.0f : i % 3 == 1 ? 1024.0f : 0.0f;
        const auto place = [&] {
            const float v = at(random);
            return raster > 0 ? std::round(v * raster) / raster : v;
        };
        const Vec2f a{place(), place()}, b{place(), place()}, c{place(), place()};
        std::vector<PixelRun> expected;
        each_run(40, 40, a, b, c, [&](const PixelRun& run) { expected.push_back(run); });
        const auto found = find_runs(40, 40, a, b, c, buffer);
        ASSERT_EQ(found.size(), expected.size());
        for (std::size_t r = 0; r < found.size(); ++r) {
            ASSERT_EQ(found[r].y, expected[r].y);
            ASSERT_EQ(found[r].end - found[r].first, expected[r].end - expected[r].first);
            if (found[r].first < found[r].end) {
                ASSERT_EQ(found[r].first, expected[r].first);
            }
        }
    }
}

TEST(Rasterize, APixelOnASharedEdgeBelongsToOneTriangle) {
    const Vec2f corners[4] = {{0, 0}, {8, 0}, {8, 8}, {0, 8}};  // the diagonal runs through pixel centres
    std::array<int, 64> owners{};
    for (int t = 0; t < 2; ++t)
        each_run(8, 8, corners[0], corners[1 + t], corners[2 + t], [&](const PixelRun& run) {
            for (int x = run.first; x < run.end; ++x) ++owners[static_cast<std::size_t>(8 * run.y + x)];
        });
    for (const int count : owners) EXPECT_EQ(count, 1);
}

// Returns the votes, open and closed, of one pair on the edge to triangle 9.
std::pair<int, int> vote(bool own_on_label, bool other_on_label, bool parted) {
    const std::int32_t neighbours[3] = {8, -1, 9};
    step::EdgeVotes votes;
    step::add_vote(votes, step::voters_of(7, neighbours), step::triangle_id(7, own_on_label),
                   step::triangle_id(9, other_on_label), parted);
    EXPECT_EQ(votes.open(0) + votes.open(1) + votes.closed(0) + votes.closed(1), 0);
    return {votes.open(2), votes.closed(2)};
}

TEST(EdgeVotes, APairSpeaksForTheSurfacesOfItsPixels) {
    EXPECT_EQ(vote(true, true, true), std::pair(1, 0)) << "both surfaces meet at a discontinuity";
    EXPECT_EQ(vote(true, true, false), std::pair(0, 1)) << "one surface goes on";
    for (const bool parted : {false, true}) {
        EXPECT_EQ(vote(true, false, parted), std::pair(0, 0)) << "one pixel is off its triangle's label";
        EXPECT_EQ(vote(false, true, parted), std::pair(0, 0));
        EXPECT_EQ(vote(false, false, parted), std::pair(0, 0));
    }
}

TEST(EdgeVotes, CountForTheEdgeTowardsThePixelsTriangle) {
    const std::int32_t neighbours[3] = {8, 4, 9};
    const step::VoterIds voters = step::voters_of(7, neighbours);
    step::EdgeVotes votes;
    const auto add = [&](std::uint32_t other, bool parted) {
        step::add_vote(votes, voters, voters.own, other, parted);
    };
    add(step::triangle_id(9, true), true);
    add(step::triangle_id(8, true), false);
    add(step::triangle_id(4, true), true);  // triangle 4 counts its own
    add(step::triangle_id(5, true), true);  // not a neighbour
    add(0, true);                           // in no triangle
    EXPECT_EQ(votes.open(2), 1);
    EXPECT_EQ(votes.closed(0), 1);
    EXPECT_EQ(votes.open(0) + votes.open(1) + votes.closed(1) + votes.closed(2), 0);
}

TEST(EdgeVotes, ANeighbourAcrossTwoEdgesCountsForTheFirst) {
    const std::int32_t neighbours[3] = {-1, 9, 9};
    const step::VoterIds voters = step::voters_of(7, neighbours);
    step::EdgeVotes votes;
    step::add_vote(votes, voters, voters.own, step::triangle_id(9, true), true);
    EXPECT_EQ(votes.open(1), 1);
    EXPECT_EQ(votes.open(2), 0);
}

TEST(EdgeVotes, NoneWhereNeitherATriangleNorANeighbourTouchesADiscontinuity) {
    const bool all[3] = {true, true, true}, but_one[3] = {true, false, true};
    EXPECT_TRUE(step::is_closed_without_vote(true, all));
    EXPECT_FALSE(step::is_closed_without_vote(false, all));
    EXPECT_FALSE(step::is_closed_without_vote(true, but_one));
}

TEST(TriangleIds, TellTheTriangle) {
    for (const std::uint32_t t : {0u, 1u, 77u})
        for (const bool on_label : {false, true}) {
            const std::uint32_t id = step::triangle_id(t, on_label);
            EXPECT_TRUE(step::belongs(id, t));
            EXPECT_FALSE(step::belongs(id, t + 1));
        }
    EXPECT_FALSE(step::belongs(0, 0)) << "nobody's";
}

TEST(Snap, ShapeIsOneIfEquilateralNoneIfFlatNegativeIfInverted) {
    const Vec2f a{0, 0}, b{2, 0}, c{1, std::sqrt(3.0f)};
    EXPECT_NEAR(step::shape(a, b, c), 1, 1e-6);
    EXPECT_NEAR(step::shape(a, c, b), -1, 1e-6);
    EXPECT_EQ(step::shape(a, b, {1, 0}), 0);
    EXPECT_EQ(step::shape(a, a, a), 0);
}

// All ways to split a triangle: the parts have the triangle's area, and their edges match.
TEST(Split, PartsCoverTheTriangle) {
    const Vec2f corners[3] = {{0, 0}, {10, 1}, {3, 9}};
    const int across[3] = {0, 1, 2};
    for (unsigned edges = 1; edges < 8; ++edges) {
        const auto place = [&](int corner) {
            if (corner < 3) return corners[corner];
            const Vec2f &p = corners[corner - 3], &q = corners[step::turned(corner - 3, 1)];
            return Vec2f{p.x + 0.4f * (q.x - p.x), p.y + 0.4f * (q.y - p.y)};
        };
        const step::Cut cut = step::cut_triangle(edges, edges, across, place);
        double area2 = 0;
        int parts = 0;
        for (int part = 0; part < step::part_count(cut.edges()); ++part) {
            if (!cut.has_part(part)) continue;
            const step::PartCorners c = step::part_corners(cut, part);
            const Vec2f a = place(c.at[0]), b = place(c.at[1]), d = place(c.at[2]);
            EXPECT_GT(cross(a, b, d.x, d.y), 0);
            area2 += cross(a, b, d.x, d.y);
            ++parts;
        }
        EXPECT_EQ(parts, 1 + cut.new_points());
        EXPECT_EQ(parts, 1 + cut.new_triangles());
        EXPECT_NEAR(area2, cross(corners[0], corners[1], corners[2].x, corners[2].y), 1e-4);
    }
}

// Six triangles around vertex 0, which two open edges divide into two fans.
TEST(VertexFans, EndAtOpenEdges) {
    std::vector<Triangle> triangles;
    std::vector<std::array<std::int32_t, 3>> neighbours;
    for (std::uint32_t i = 0; i < 6; ++i) {
        triangles.push_back({0, 1 + i, 1 + (i + 1) % 6});
        neighbours.push_back(
            {static_cast<std::int32_t>((i + 5) % 6), -1, static_cast<std::int32_t>((i + 1) % 6)});
    }
    std::vector<std::array<std::uint8_t, 3>> open(6, {0, 0, 0});
    const std::vector<std::uint8_t> kept(6, 1);
    const step::FanView<decltype(neighbours.data()), decltype(open.data())> view{
        triangles.data(), neighbours.data(), open.data(), kept.data()};
    const auto fan_of = [&](std::uint32_t t) {
        std::set<std::uint32_t> fan{t};
        step::each_of_fan(view, {t, 0}, [&](const step::Corner& c) { return fan.insert(c.triangle).second; });
        return fan;
    };
    EXPECT_EQ(fan_of(2).size(), 6u);
    open[0][0] = 1;  // to triangle 5: the entry of an edge's lower triangle counts
    open[2][2] = 1;  // to triangle 3
    EXPECT_EQ(fan_of(1), (std::set<std::uint32_t>{0, 1, 2}));
    EXPECT_EQ(fan_of(4), (std::set<std::uint32_t>{3, 4, 5}));
}

}  // namespace
}  // namespace hexrelief::surface
