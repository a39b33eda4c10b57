// Tests the correction of the right picture's light.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "pipeline/matching/matcher.h"
#include "samples/sample_pair.h"

namespace hexrelief::matching {
namespace {

StereoPair sample_pair() {
    return samples::render_sample_scene().pair;
}

template <typename Change>
StereoPair with_other_light(StereoPair pair, const Change& change) {
    for (std::size_t i = 0; i < pair.right.pixels.size(); ++i)
        pair.right.pixels[i] = static_cast<std::uint8_t>(std::lround(change(pair.right.pixels[i])));
    return pair;
}

double mean_difference(const Image& a, const Image& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) sum += std::abs(a.pixels[i] - b.pixels[i]);
    return sum / static_cast<double>(a.pixels.size());
}

MatchedMap matched(const StereoPair& pair) {
    return match_trusted(pair, {{0, 64}, {}, {}}, 2);
}

Image relit(const StereoPair& pair) {
    Image right = pair.right;
    relight(right, find_light(pair, matched(pair), 0), 2);
    return right;
}

TEST(Light, OneLightStaysNearlyAsItIs) {
    const StereoPair pair = sample_pair();
    EXPECT_LT(mean_difference(relit(pair), pair.right), 1.5);
}

TEST(Light, AnotherExposureAndGammaAreUndone) {
    const StereoPair pair = sample_pair();
    const auto darker = [](double level) { return 0.6 * level; };
    const auto steeper = [](double level) { return 204 * std::pow(level / 255, 1.4); };
    for (const StereoPair& other : {with_other_light(pair, darker), with_other_light(pair, steeper)}) {
        EXPECT_GT(mean_difference(other.right, pair.right), 20);
        EXPECT_LT(mean_difference(relit(other), pair.right), 4);
    }
}

TEST(Light, GreyBesideColourHasOneCurve) {
    const StereoPair pair = sample_pair();
    Image grey{pair.right.width, pair.right.height, 1, {}}, darker = grey;
    for (std::size_t i = 0; i < pair.right.pixels.size(); i += 3) {
        grey.pixels.push_back(pair.right.pixels[i + 1]);
        darker.pixels.push_back(static_cast<std::uint8_t>(pair.right.pixels[i + 1] * 0.6));
    }
    const LightCurves same = find_light({pair.left, grey}, matched({pair.left, grey}), 0),
                      other = find_light({pair.left, darker}, matched({pair.left, darker}), 0);
    ASSERT_EQ(same.size(), 1u);
    ASSERT_EQ(other.size(), 1u);
    relight(grey, same, 2);
    relight(darker, other, 2);
    EXPECT_LT(mean_difference(darker, grey), 3);
}

TEST(Light, CurvesNeverFall) {
    const StereoPair pair = sample_pair();
    const LightCurves curves = find_light(pair, matched(pair), 0);
    ASSERT_EQ(curves.size(), 3u);
    for (const auto& curve : curves) EXPECT_TRUE(std::is_sorted(curve.begin(), curve.end()));
}

TEST(Light, StaysAsItIsWhereNothingTells) {
    StereoPair pair = sample_pair();
    MatchedMap map = matched(pair);
    Image right = pair.right;
    relight(right, {}, 1);
    EXPECT_EQ(right.pixels, pair.right.pixels);
    std::fill(map.is_matched.begin(), map.is_matched.end(), 0);
    EXPECT_TRUE(find_light(pair, map, 0).empty());
}

}  // namespace
}  // namespace hexrelief::matching
