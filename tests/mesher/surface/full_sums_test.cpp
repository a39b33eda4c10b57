// Tests the sums of triangles from their moments against the sums over single pixels.
#include "mesher/surface/fit/disparity_fitter_step.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "mesher/surface/pixels/discontinuities_step.h"

namespace hexrelief::surface {
namespace {

struct Pixel {
    int x, y;
    float d;
};

// A triangle somewhere in a large image, on a plane through the disparities at its corners.
struct Patch {
    std::array<std::array<float, 2>, 3> at;
    std::array<double, 3> corner;

    // Returns a pixel centre's shares of the corners, by the areas opposite to them.
    std::array<long double, 3> shares(int x, int y) const {
        const auto cross = [](long double ax, long double ay, long double bx, long double by) {
            return ax * by - ay * bx;
        };
        std::array<long double, 3> out{};
        const long double px = x + 0.5L, py = y + 0.5L;
        const long double all = cross(
            static_cast<long double>(at[1][0]) - at[0][0], static_cast<long double>(at[1][1]) - at[0][1],
            static_cast<long double>(at[2][0]) - at[0][0], static_cast<long double>(at[2][1]) - at[0][1]);
        for (int k = 0; k < 3; ++k) {
            const auto &b = at[(k + 1) % 3], &c = at[(k + 2) % 3];
            out[k] = cross(b[0] - px, b[1] - py, c[0] - px, c[1] - py) / all;
        }
        return out;
    }
    // Returns the pixels, with d = the plane's disparity plus noise(), rounded to float.
    template <typename Noise>
    std::vector<Pixel> pixels(const Noise& noise) const {
        std::vector<Pixel> out;
        const auto [left, right] = std::minmax({at[0][0], at[1][0], at[2][0]});
        const auto [top, bottom] = std::minmax({at[0][1], at[1][1], at[2][1]});
        for (int y = static_cast<int>(top) - 1; y < bottom + 1; ++y)
            for (int x = static_cast<int>(left) - 1; x < right + 1; ++x) {
                const auto l = shares(x, y);
                if (std::min({l[0], l[1], l[2]}) < 0) continue;
                const double plane =
                    static_cast<double>(l[0] * corner[0] + l[1] * corner[1] + l[2] * corner[2]);
                out.push_back({x, y, static_cast<float>(plane + noise())});
            }
        return out;
    }
    step::PlanePatch step_patch() const {
        return step::plane_patch(at[0][0], at[0][1], at[1][0], at[1][1], at[2][0], at[2][1]);
    }
    double shape() const {  // twice the area over the square of the longest edge
        double longest = 0;
        for (int k = 0; k < 3; ++k)
            longest = std::max(longest, std::pow(double(at[k][0]) - at[(k + 1) % 3][0], 2) +
                                            std::pow(double(at[k][1]) - at[(k + 1) % 3][1], 2));
        const double twice_area = (double(at[1][0]) - at[0][0]) * (double(at[2][1]) - at[0][1]) -
                                  (double(at[1][1]) - at[0][1]) * (double(at[2][0]) - at[0][0]);
        return std::fabs(twice_area) / longest;
    }
};

class Random {
  public:
    explicit Random(unsigned seed) : engine_(seed) {}
    double operator()(double from, double to) {
        return from + (to - from) * static_cast<double>(engine_()) / 4294967296.0;
    }
    // Returns a triangle whose corners' disparities differ by less than `rise`.
    Patch patch(double rise) {
        Patch p{};
        const double x = (*this)(0, 16000), y = (*this)(0, 16000), size = (*this)(2, 40);
        for (auto& corner : p.at)
            corner = {static_cast<float>(x + (*this)(0, size)), static_cast<float>(y + (*this)(0, size))};
        const double base = (*this)(2, 250);
        for (double& corner : p.corner) corner = base + (*this)(0, rise);
        return p;
    }

  private:
    std::mt19937 engine_;
};

step::Moments moments_of(const std::vector<Pixel>& pixels) {
    step::Moments m;
    for (const Pixel& p : pixels) step::add_pixel(m, p.x, p.y, p.d);
    return m;
}

TEST(FullSums, AreThoseOfThePixels) {
    Random random(7);
    int passed = 0, all = 0;
    for (int i = 0; i < 5000; ++i) {
        const Patch patch = random.patch(0.5);
        const auto pixels = patch.pixels([&] { return random(-0.24, 0.24); });
        if (pixels.empty()) continue;
        const step::Moments m = moments_of(pixels);
        const bool fits = step::holds_sums(patch.step_patch());
        if (patch.shape() > 0.04) {
            EXPECT_TRUE(fits) << patch.shape();
        }
        ++all;
        if (!fits) continue;
        ++passed;
        const step::TriangleSums sums = step::full_sums(m, patch.step_patch());
        long double own[3]{}, cross[3]{}, right[3]{}, sizes[3]{};
        for (const Pixel& p : pixels) {
            const auto l = patch.shares(p.x, p.y);
            for (int k = 0; k < 3; ++k) {
                own[k] += l[k] * l[k];
                cross[k] += l[k] * l[(k + 1) % 3];
                right[k] += l[k] * p.d;
                sizes[k] += l[k];
            }
        }
        // relative to the sums of all corners, because a corner without pixels near it has almost none
        const double n = static_cast<double>(pixels.size());
        for (int k = 0; k < 3; ++k) {
            ASSERT_NEAR(sums.own[k], static_cast<double>(own[k]), 1e-9 * n) << patch.shape();
            ASSERT_NEAR(sums.cross[k], static_cast<double>(cross[k]), 1e-9 * n) << patch.shape();
            ASSERT_NEAR(sums.right[k], static_cast<double>(right[k]), 1e-9 * m.d) << patch.shape();
            if (sizes[k] > 0.1L * n && patch.shape() > 0.2) {  // relative to the corner's own sum as well
                ASSERT_NEAR(sums.own[k], static_cast<double>(own[k]), 1e-9 * static_cast<double>(own[k]));
                ASSERT_NEAR(sums.right[k], static_cast<double>(right[k]),
                            1e-9 * static_cast<double>(right[k]));
            }
        }
    }
    EXPECT_GT(passed, 0.9 * all);
}

TEST(FullSums, AreNotForTrianglesWithoutArea) {
    const Patch flat{{{{10, 10}, {20, 20}, {30, 30}}}, {5, 5, 5}},
        good{{{{10, 10}, {30, 10}, {10, 30}}}, {5, 5, 5}};
    EXPECT_FALSE(step::holds_sums(flat.step_patch()));
    EXPECT_TRUE(step::holds_sums(good.step_patch()));
}

// If a triangle has a pixel behind a low half-occlusion step, one of its rows has a discontinuity before a
// pixel: this searches all pairs of neighbours.
TEST(FullSums, NoHalfOcclusionIsOverlooked) {
    Random random(9);
    constexpr int kSize = 12;
    int half_occlusions = 0;
    for (int i = 0; i < 500; ++i) {
        std::vector<float> disparity(kSize * kSize);
        std::vector<std::uint8_t> flags(kSize * kSize, 0);
        for (float& d : disparity) d = random(0, 1) < 0.1 ? 13.0f : random(0, 1) < 0.05 ? 25.0f : 10.0f;
        const auto at = [&](int x, int y) { return static_cast<std::size_t>(y) * kSize + x; };
        const auto discontinuities = [&](int x, int y) {
            return disparity[at(x, y)] != disparity[at(x + 1, y)];
        };
        for (int y = 0; y < kSize; ++y)
            for (int x = 0; x + 1 < kSize; ++x)
                if (discontinuities(x, y)) flags[at(x, y)] = step::kDiscontinuityRight;
        const step::PixelView view{kSize, kSize, disparity.data(), flags.data()};
        const int y = static_cast<int>(random(0, kSize)), first = static_cast<int>(random(0, kSize)),
                  end = static_cast<int>(random(first + 1, kSize + 1));
        bool expected = false;
        for (int x = first; x < end; ++x) {
            int edge = x - 1;  // the last discontinuity on the left
            while (edge >= 0 && !discontinuities(edge, y)) --edge;
            if (edge < 0 || x - edge > 2) continue;
            const float half_occlusion = disparity[at(edge, y)] - disparity[at(edge + 1, y)];
            const bool low = half_occlusion > 0 && half_occlusion < 6;
            expected |= low;
            EXPECT_EQ(step::is_behind_low_half_occlusion(view, x, y), low);
        }
        half_occlusions += expected;
        EXPECT_TRUE(!expected || step::has_discontinuity_before(view, y, first, end));
    }
    EXPECT_GT(half_occlusions, 50);
}

}  // namespace
}  // namespace hexrelief::surface
