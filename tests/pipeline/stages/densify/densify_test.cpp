#include "pipeline/stages/densify/densify.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "pipeline/stages/densify/measurements.h"
#include "pipeline/stages/densify/plane_votes.h"

namespace hexrelief::stages {
namespace {

using Surface = std::function<double(int, int)>;
using Keeps = std::function<bool(int, int)>;

unsigned percent_at(int x, int y) {
    unsigned hash = static_cast<unsigned>(x) * 2654435761u ^ static_cast<unsigned>(y) * 2246822519u;
    hash ^= hash >> 15;
    hash *= 2654435761u;
    return (hash ^ (hash >> 13)) % 100;
}

Keeps random_share(unsigned percent) {
    return [percent](int x, int y) { return percent_at(x, y) < percent; };
}
Keeps every_row(int apart) {
    return [apart](int, int y) { return y % apart == apart / 2; };
}

DisparityMap sampled(int width, int height, const Surface& surface, const Keeps& keeps) {
    DisparityMap map{width, height, std::vector<float>(static_cast<std::size_t>(width) * height)};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            map.at(x, y) = keeps(x, y) ? static_cast<float>(surface(x, y)) : kUnknownDisparity;
    return map;
}

double slanted(int x, int y) {
    return 20 + 0.11 * x - 0.07 * y;
}

// A disc in front of a wall.
bool in_disc(int x, int y) {
    return (x - 60) * (x - 60) + (y - 45) * (y - 45) < 30 * 30;
}
double disc(int x, int y) {
    return in_disc(x, y) ? 40 : 10;
}
Image disc_picture() {
    Image picture{120, 90, 1, {}};
    for (int y = 0; y < 90; ++y)
        for (int x = 0; x < 120; ++x)
            picture.pixels.push_back(static_cast<std::uint8_t>(in_disc(x, y) ? 180 : 60));
    return picture;
}

// Returns the share of the pixels that are on the wrong surface; `blended` gets those that are on neither.
double wrong_share(const DisparityMap& map, double& blended) {
    int wrong = 0, between = 0;
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            wrong += !(std::abs(map.at(x, y) - disc(x, y)) <= 1);
            between += map.at(x, y) > 11 && map.at(x, y) < 39;
        }
    const double pixels = double(map.width) * map.height;
    blended = between / pixels;
    return wrong / pixels;
}

bool is_sparse(const DisparityMap& map) {
    return measure_sparsity(map).is_sparse();
}

}  // namespace

TEST(Sparsity, ScatteredMeasurementsAndScanLinesAreSparse) {
    for (const Keeps& keeps : {random_share(5), random_share(20), random_share(40), every_row(5),
                               every_row(20), Keeps([](int x, int) { return x % 4 == 0; })})
        EXPECT_TRUE(is_sparse(sampled(160, 120, slanted, keeps)));
}

TEST(Sparsity, SurfacesWithHolesAreDense) {
    const auto blocks = [](int side, unsigned percent) {
        return [=](int x, int y) { return percent_at(x / side, y / side) >= percent; };
    };
    EXPECT_FALSE(is_sparse(sampled(160, 120, slanted, [](int, int) { return true; })));
    for (const int side : {3, 8, 40}) EXPECT_FALSE(is_sparse(sampled(160, 120, slanted, blocks(side, 50))));
    EXPECT_FALSE(is_sparse(sampled(160, 120, slanted, random_share(80))));
    EXPECT_FALSE(is_sparse(sampled(160, 120, slanted, [](int x, int y) { return x > 100 && y > 90; })));
}

TEST(Sparsity, NothingAndNearlyNothingAreNotSparse) {
    EXPECT_FALSE(is_sparse({}));
    EXPECT_FALSE(is_sparse(sampled(160, 120, slanted, random_share(0))));
    EXPECT_FALSE(is_sparse(sampled(160, 120, slanted, [](int x, int y) { return x == 9 && y == 9; })));
}

// Compares with plain loops over all measurements, and over the squares of a closing.
TEST(Densify, DistancesAndReachAreThoseOfPlainLoops) {
    const DisparityMap map = sampled(90, 80, slanted, [](int x, int y) {
        return percent_at(x, y) < 12 && !(x > 20 && x < 70 && y > 10 && y < 60);
    });
    const std::vector<PlaneAt> measured = measurements_of(map);
    const NearestMeasurements nearest = find_nearest(measured, map.width, map.height, {});
    const int typical_px = typical_distance_px(map, nearest), radius = 3 * typical_px + 4;
    const auto pixels = pixels_to_fill(map, nearest, typical_px);
    const auto is_any = [&](int x, int y, const auto& asked) {
        for (int j = std::max(0, y - radius); j <= std::min(map.height - 1, y + radius); ++j)
            for (int i = std::max(0, x - radius); i <= std::min(map.width - 1, x + radius); ++i)
                if (asked(i, j)) return true;
        return false;
    };
    std::vector<std::uint8_t> dilated;
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x)
            dilated.push_back(is_any(x, y, [&](int i, int j) { return DisparityMap::known(map.at(i, j)); }));
    int filled = 0;
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            const std::size_t at = static_cast<std::size_t>(y) * map.width + x;
            unsigned least = ~0u;
            for (const PlaneAt& m : measured) {
                const int dx = std::abs(m.x - x), dy = std::abs(m.y - y), diagonal = std::min(dx, dy);
                least = std::min(least, 23u * diagonal + 16u * (std::max(dx, dy) - diagonal));
            }
            ASSERT_EQ(nearest.distance[at], least) << x << ' ' << y;
            const bool is_closed = !is_any(x, y, [&](int i, int j) { return !dilated[j * map.width + i]; });
            ASSERT_EQ(pixels[at] != 0, is_closed || least <= 16u * (typical_px + 2)) << x << ' ' << y;
            filled += pixels[at];
        }
    EXPECT_LT(filled, map.width * map.height) << "the hole is too small";
}

TEST(Densify, PlanesComeBack) {
    for (const Keeps& keeps : {random_share(5), random_share(20), every_row(5), every_row(20)}) {
        const DisparityMap dense = densify(sampled(160, 120, slanted, keeps), {}, 2);
        double largest = 0;
        for (int y = 10; y < 110; ++y)
            for (int x = 10; x < 150; ++x)
                largest = std::max(largest, std::abs(dense.at(x, y) - slanted(x, y)));
        EXPECT_LT(largest, 0.05);
    }
}

TEST(Densify, MeasurementsStayAndOriginsTellThemApart) {
    const DisparityMap sparse = sampled(90, 70, slanted, random_share(10));
    const DisparityMap dense = densify(sparse, {}, 1);
    for (std::size_t i = 0; i < sparse.values.size(); ++i)
        if (DisparityMap::known(sparse.values[i])) {
            EXPECT_EQ(dense.values[i], sparse.values[i]);
            EXPECT_EQ(dense.origins[i], PixelOrigin::matched);
        } else {
            EXPECT_EQ(dense.origins[i],
                      DisparityMap::known(dense.values[i]) ? PixelOrigin::filled : PixelOrigin::unknown);
        }
}

TEST(Densify, StepsFollowThePicture) {
    for (const Keeps& keeps : {random_share(5), every_row(10)}) {
        double blended = 0;
        EXPECT_LT(wrong_share(densify(sampled(120, 90, disc, keeps), disc_picture(), 1), blended), 0.002);
        EXPECT_EQ(blended, 0);
    }
}

TEST(Densify, StepsAreSharpWithoutAPicture) {
    for (const Keeps& keeps : {random_share(5), every_row(10)}) {
        double blended = 0;
        EXPECT_LT(wrong_share(densify(sampled(120, 90, disc, keeps), {}, 1), blended), 0.05);
        EXPECT_EQ(blended, 0);
    }
}

// A straight step must not be bent by the positions of the measurements.
TEST(Densify, StraightStepsStayStraightWithoutAPicture) {
    const auto step = [](int x, int y) { return 2 * x + y > 160 ? 40.0 : 10.0; };
    const DisparityMap dense = densify(sampled(120, 90, step, random_share(20)), {}, 1);
    int wrong = 0;
    for (int y = 0; y < 90; ++y)
        for (int x = 0; x < 120; ++x) wrong += !(std::abs(dense.at(x, y) - step(x, y)) <= 1);
    EXPECT_LT(wrong, 60) << "66 where the heavier surface holds";
}

TEST(Densify, PicturesAreSmoothedByOneTwoOne) {
    ThreadPool pool(2);
    const Image smooth = smoothed({3, 2, 1, {0, 160, 0, 0, 0, 32}}, pool);
    // Computed by hand: the picture's edges are repeated.
    EXPECT_EQ(smooth.pixels, (std::vector<std::uint8_t>{30, 62, 36, 10, 26, 28}));
    EXPECT_TRUE(smoothed({}, pool).empty());
}

TEST(Densify, SkyAndWhatLiesFarFromMeasurementsStayUnknown) {
    const auto ground = [](int, int y) { return y >= 60 && y % 5 == 0; };
    const DisparityMap dense = densify(sampled(160, 120, slanted, ground), {}, 1);
    for (int x = 0; x < 160; ++x) {
        for (int y = 0; y < 54; ++y) EXPECT_FALSE(DisparityMap::known(dense.at(x, y)));
        for (int y = 60; y < 120; ++y) EXPECT_TRUE(DisparityMap::known(dense.at(x, y)));
    }
}

// 64 scan lines of a street and a box, with a fifth of the pixels below the horizon and none in the sky.
TEST(Densify, ALaserLeavesTheSkyAndInventsNoDepth) {
    constexpr int kTop = 64, kApart = 2;
    const auto street = [](int x, int y) {
        return x > 80 && x < 110 && y < 120 ? 45.0 : 10 + 0.4 * (y - kTop);
    };
    const auto line = [](int x, int y) {
        return y >= kTop && (y - kTop) % kApart == 0 && percent_at(x, y) < 20 * kApart;
    };
    const DisparityMap sparse = sampled(240, kTop + 64 * kApart, street, line);
    ASSERT_TRUE(is_sparse(sparse));
    const DisparityMap dense = densify(sparse, {}, 1);
    int wrong = 0;
    for (int y = 0; y < dense.height; ++y)
        for (int x = 0; x < dense.width; ++x) {
            const float d = dense.at(x, y);
            EXPECT_FALSE(y < kTop - 8 && DisparityMap::known(d)) << x << ' ' << y;
            EXPECT_TRUE(y < kTop || (d >= 9 && d <= 10 + 0.4 * 64 * kApart + 1)) << x << ' ' << y;
            wrong += y >= kTop && std::abs(d - street(x, y)) > 1;
        }
    EXPECT_LT(wrong, 240 * 64 * kApart / 50);
}

// A hole with measurements on both sides, and above and below at the far ends, is not a gap.
TEST(Densify, LargeHolesStayUnknown) {
    for (const Keeps& keeps : {random_share(20), random_share(5), every_row(5)}) {
        const DisparityMap towers = sampled(
            240, 160, slanted, [&](int x, int y) { return keeps(x, y) && (y >= 100 || x < 70 || x >= 170); });
        const DisparityMap dense = densify(towers, {}, 1);
        for (int x = 100; x < 140; ++x)
            for (int y = 0; y < 80; ++y) ASSERT_FALSE(DisparityMap::known(dense.at(x, y))) << x << ' ' << y;
    }
}

TEST(Densify, TheSameOnAnyNumberOfThreads) {
    const DisparityMap sparse = sampled(120, 90, disc, random_share(10));
    const DisparityMap one = densify(sparse, disc_picture(), 1);
    for (const int threads : {2, 3, 7}) {
        const DisparityMap other = densify(sparse, disc_picture(), threads);
        EXPECT_EQ(other.values, one.values);
        EXPECT_EQ(other.origins, one.origins);
    }
}

TEST(Densify, SmallMaps) {
    const DisparityMap one = densify({1, 1, {5}}, {}, 2);
    EXPECT_EQ(one.values, std::vector<float>{5});
    const DisparityMap row = densify({3, 1, {5, kUnknownDisparity, 5}}, {}, 2);
    EXPECT_EQ(row.values, (std::vector<float>{5, 5, 5}));
    const DisparityMap none = densify({2, 1, {kUnknownDisparity, kUnknownDisparity}}, {}, 2);
    EXPECT_FALSE(DisparityMap::known(none.at(0, 0)) || DisparityMap::known(none.at(1, 0)));
}

TEST(FillHoles, AHoleLiesOnThePlaneAroundIt) {
    const DisparityMap map = sampled(
        90, 70, slanted, [](int x, int y) { return !(x > 30 && x < 55 && y > 20 && y < 50) && x < 80; });
    const DisparityMap full = fill_holes(map, {}, 2);
    double nearest = 0;
    for (const float d : map.values)
        if (DisparityMap::known(d)) nearest = std::max<double>(nearest, d);
    for (int y = 0; y < 70; ++y)
        for (int x = 0; x < 90; ++x) {
            const std::size_t i = static_cast<std::size_t>(y) * 90 + x;
            const bool is_known = DisparityMap::known(map.values[i]);
            EXPECT_EQ(full.origins[i], is_known ? PixelOrigin::matched : PixelOrigin::filled);
            // Planes go on to the border, but to nothing nearer than what is known.
            EXPECT_NEAR(full.values[i], std::min(slanted(x, y), nearest), is_known ? 1e-5 : 0.6)
                << x << " " << y;
        }
    EXPECT_EQ(fill_holes(map, {}, 1).values, full.values);
}

}  // namespace hexrelief::stages
