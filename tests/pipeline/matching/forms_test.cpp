// Compares the steps that devices take for two numbers in a word, or in fewer instructions, with the plain
// text of their rules. If a step is a template of the word, both words are tried.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <vector>

#include "pipeline/matching/common/color_step.h"
#include "pipeline/matching/common/halves_step.h"
#include "pipeline/matching/refine/slope_step.h"
#include "pipeline/matching/refine/smooth_step.h"
#include "pipeline/matching/refine/vote_step.h"
#include "pipeline/matching/sgm/path_step.h"

namespace hexrelief::matching {
namespace {

using Lane = std::uint16_t;
using Pair = std::uint32_t;

Pair pair_of(unsigned low, unsigned high) {
    return (low & 0xffffu) | high << 16;
}
unsigned half_of(Pair pair, int half) {
    return pair >> (16 * half) & 0xffffu;
}
int with_sign(unsigned half) {
    return static_cast<std::int16_t>(half);
}

// Returns the 16-bit numbers around each power of two.
std::vector<unsigned> edges() {
    std::vector<unsigned> values;
    for (unsigned bit = 1; bit <= 0x10000u; bit *= 2)
        for (const unsigned value : {bit - 1, bit, bit + 1})
            if (value <= 0xffffu) values.push_back(value);
    return values;
}

TEST(Halves, DoWhatEachNumberAloneDoes) {
    const std::vector<unsigned> values = edges();
    const auto expect = [](unsigned low, unsigned high, Lane lane, Pair pair) {
        return lane == low && pair == pair_of(low, high);
    };
    long different = 0;
    for (const unsigned a : values)
        for (const unsigned b : values)
            for (const unsigned c : values) {
                // the upper half takes the numbers in another order
                const auto lane = [](unsigned value) { return static_cast<Lane>(value); };
                const Pair ab = pair_of(a, b), bc = pair_of(b, c), ca = pair_of(c, a);
                different += !expect(std::min(a, b), std::min(b, c), step::least_of(lane(a), lane(b)),
                                     step::least_of(ab, bc));
                different += !expect(std::min({a, b, c}), std::min({a, b, c}),
                                     step::least_of(lane(a), lane(b), lane(c)), step::least_of(ab, bc, ca));
                const auto sum = [](unsigned x, unsigned y) { return (x + y) & 0xffffu; };
                different +=
                    !expect(std::min(sum(a, b), c), std::min(sum(b, c), a),
                            step::least_of_sum(lane(a), lane(b), lane(c)), step::least_of_sum(ab, bc, ca));
                const auto or_0 = [&](unsigned x, unsigned y, unsigned z) {
                    return static_cast<unsigned>(std::max(0, std::min(with_sign(sum(x, y)), with_sign(z))));
                };
                different +=
                    !expect(or_0(a, b, c), or_0(b, c, a), step::least_of_sum_or_0(lane(a), lane(b), lane(c)),
                            step::least_of_sum_or_0(ab, bc, ca));
                if (a < b || b < c) continue;
                different +=
                    !expect(std::min(a - b, c), std::min(b - c, a),
                            step::least_of_difference(lane(a), lane(b), lane(0x10000u - b), lane(c)),
                            step::least_of_difference(ab, bc, pair_of(0x10000u - b, 0x10000u - c), ca));
            }
    EXPECT_EQ(different, 0);
}

// Hirschmueller 2008, eq. 13.
int plain_path_cost(int before, int lower, int upper, int least, int p1, int p2, int cost) {
    return std::min({before, lower + p1, upper + p1, least + p2}) - least + cost;
}

TEST(PathCost, IsEquation13InEitherWord) {
    std::mt19937 random(7);
    const auto below = [&](int end) { return static_cast<int>(random() % static_cast<unsigned>(end)); };
    const int no_path = step::kNoPath;
    for (int k = 0; k < 200000; ++k) {
        const bool largest = k % 7 == 0;
        const int p1 = largest ? 15999 : 1 + below(16000), p2 = largest ? 16000 : 1 + below(16000),
                  least = below(16256);
        int values[3][2], costs[2] = {below(256), below(256)};  // before, lower, upper
        for (auto& value : values)
            for (int& half : value) half = below(5) == 0 ? no_path : least + below(16256 - least + 1) + p1;
        const auto lanes = step::path_steps(static_cast<Lane>(least + p1), step::small_step<Lane>(p1),
                                            static_cast<Lane>(p2));
        const auto pairs =
            step::path_steps(pair_of(least + p1, least + p1), step::small_step<Pair>(p1), pair_of(p2, p2));
        const auto pair = [](const int(&halves)[2]) {
            return pair_of(static_cast<unsigned>(halves[0]), static_cast<unsigned>(halves[1]));
        };
        const Pair both =
            step::path_cost(pair(values[0]), pair(values[1]), pair(values[2]), pairs, pair(costs));
        for (int half = 0; half < 2; ++half) {
            const auto plain = [&](int i) {
                return values[i][half] == no_path ? 1 << 20 : values[i][half] - p1;
            };
            const int expected =
                p1 + plain_path_cost(plain(0), plain(1), plain(2), least, p1, p2, costs[half]);
            const auto lane = [&](int i) { return static_cast<Lane>(values[i][half]); };
            ASSERT_EQ(step::path_cost(lane(0), lane(1), lane(2), lanes, static_cast<Lane>(costs[half])),
                      expected);
            ASSERT_EQ(half_of(both, half), static_cast<unsigned>(expected));
        }
    }
}

TEST(MatchingCost, IsTheSameInEitherWord) {
    for (unsigned a = 0; a < 256; ++a)
        ASSERT_EQ(half_of(step::cut_difference(pair_of(a, 255 - a)), 0),
                  step::cut_difference(static_cast<std::uint8_t>(a)));
    for (const int channels : {1, 3})
        for (unsigned hamming = 0; hamming <= step::kCensusBits; ++hamming)
            for (unsigned differences = 0; differences <= 40u * static_cast<unsigned>(channels);
                 ++differences) {
                const unsigned expected = 3 * hamming + differences / (channels == 3 ? 8 : 2);
                ASSERT_EQ(step::matching_cost(static_cast<std::uint8_t>(hamming),
                                              static_cast<std::uint8_t>(differences), channels),
                          expected);
                for (const unsigned other : {0u, 7u, 40u})
                    for (const bool upper : {false, true}) {
                        const Pair both = step::matching_cost(
                            upper ? pair_of(other, hamming) : pair_of(hamming, other),
                            upper ? pair_of(other, differences) : pair_of(differences, other), channels);
                        ASSERT_EQ(half_of(both, upper), expected);
                    }
            }
}

// A pixel's disparity and those of the samples beside it.
using Line = std::array<int, step::kSamples + 1>;

struct Samples {
    int count = 0, v = 0, tv = 0;
};
Samples plain_samples(const Line& line) {
    Samples samples;
    for (int k = 1; k <= step::kSamples; ++k) {
        if (line[k] < 0 || std::abs(line[k] - line[k - 1]) > step::kLineStep) break;
        ++samples.count;
        samples.v += line[k] - line[0];
        samples.tv += k * (line[k] - line[0]);
    }
    return samples;
}
bool are_those(const Samples& samples, unsigned v, unsigned tv) {
    return step::SideSum(v).count == samples.count && step::SideSum(v).sum == samples.v &&
           step::SideSum(tv).sum == samples.tv;
}

// Covers every run of steps up to the largest that a line allows, at both ends of the disparities, with one
// line beside another.
TEST(LineSamples, AreThoseOfARunInEitherWord) {
    constexpr int kSteps[] = {-30000, -21, -20, -19, -7, -1, 0, 1, 8, 19, 20, 21, 30000};
    constexpr int kKinds = std::size(kSteps) + 1, kLines = kKinds * kKinds * kKinds * kKinds;
    constexpr int kLargest = 16 * 1920 + 512;
    const auto line_of = [&](int number, int own) {
        Line line{own};
        for (int k = 1, last = own; k <= step::kSamples; ++k, number /= kKinds) {
            const int kind = number % kKinds;
            if (kind + 1 < kKinds) last = std::clamp(last + kSteps[kind], 0, kLargest);
            line[k] = kind + 1 < kKinds ? last : -1;
        }
        return line;
    };
    long different = 0;
    for (const int own : {0, 13, 5000, kLargest})
        for (int number = 0; number < kLines; ++number) {
            const Line lines[2] = {line_of(number, own), line_of((number + 12345) % kLines, kLargest - own)};
            step::SideSums<Lane> lanes[2] = {{1}, {1}};
            step::SideSums<Pair> pair{step::kBoth};
            for (int k = 1; k <= step::kSamples; ++k) {
                const auto here = [&](int i) {
                    return static_cast<unsigned>(lines[i][k]) | step::kUnknownBit;
                };
                const auto before = [&](int i) {
                    return static_cast<unsigned>(lines[i][k - 1]) & ~step::kUnknownBit & 0xffffu;
                };
                const auto first = [&](int i) { return static_cast<unsigned>(lines[i][0]); };
                for (int i = 0; i < 2; ++i)
                    lanes[i].add(static_cast<unsigned>(k), static_cast<Lane>(here(i)),
                                 static_cast<Lane>(before(i)), static_cast<Lane>(first(i)));
                pair.add(static_cast<unsigned>(k), pair_of(here(0), here(1)), pair_of(before(0), before(1)),
                         pair_of(first(0), first(1)));
            }
            for (int i = 0; i < 2; ++i) {
                const Samples expected = plain_samples(lines[i]);
                different += !are_those(expected, lanes[i].v, lanes[i].tv);
                different += !are_those(expected, half_of(pair.v, i), half_of(pair.tv, i));
            }
        }
    EXPECT_EQ(different, 0);
}

// Products of floats equal quotients of integers for all sums that a line's samples, or a window's slopes,
// can have, and more.
TEST(Slopes, AreQuotientsOfWholeNumbers) {
    const auto rounded = [](int sum, int count) {
        const int twice = 2 * sum + count, divisor = 2 * count;
        return twice / divisor - (twice % divisor < 0);
    };
    for (int before = 0; before <= step::kSamples; ++before)
        for (int behind = 0; behind <= step::kSamples; ++behind) {
            const step::LinePlaces places(before, behind);
            int n = 0, t = 0, squares = 0;
            for (int k = -before; k <= behind; ++k) {
                ++n;
                t += k;
                squares += k * k;
            }
            ASSERT_EQ(places.n, n);
            ASSERT_EQ(places.t, t);
            constexpr int kMost_v = 2 * step::kLineStep * 10, kMost_tv = 2 * step::kLineStep * 30,
                          kMost = 9 * kMost_tv + 10 * kMost_v;
            for (int x = -kMost; x <= kMost; ++x) {
                const int slope = n < step::kLeastSamples ? 0
                                                          : std::clamp(rounded(16 * x, n * squares - t * t),
                                                                       -step::kSteepest, step::kSteepest);
                ASSERT_EQ(step::rounded_slope(x, places.scale), slope)
                    << x << ", " << before << " before, " << behind << " behind";
            }
        }
    for (int count = 1; count <= step::kMostSlopes; ++count)
        for (int sum = -count * step::kSteepest; sum <= count * step::kSteepest; ++sum)
            ASSERT_EQ(step::rounded_slope(sum, step::share_of(count)), rounded(sum, count))
                << sum << " of " << count;
}

// Covers every distance off the plane, in either half.
TEST(Smoothing, WeighsAPixelTheSameInEitherWord) {
    constexpr int kReach = step::kSmoothReach;
    long different = 0;
    for (int off = -0x8000 + kReach + 1; off < 0x8000 - kReach; ++off) {
        const auto above = static_cast<unsigned>(off + kReach);
        const int expected = std::max(0, std::min(kReach + off, kReach - off));
        different += step::nearness(static_cast<Lane>(above)) != expected;
        for (const unsigned other : {0u, 1u, 44u, 88u, 89u, 0x7fffu, 0x8000u, 0xffffu}) {
            different += half_of(step::nearness(pair_of(above, other)), 0) != static_cast<unsigned>(expected);
            different += half_of(step::nearness(pair_of(other, above)), 1) != static_cast<unsigned>(expected);
        }
        for (const unsigned kernel : {1u, 2u, 3u, 4u, 6u, 9u}) {
            step::SmoothSums<Lane> lane;
            lane.add(static_cast<Lane>(kernel), static_cast<Lane>(expected), static_cast<Lane>(above));
            lane.add(static_cast<Lane>(kernel), 44, 44);
            step::SmoothSums<Pair> pair;
            pair.add(kernel, pair_of(static_cast<unsigned>(expected), 44), pair_of(above, 44));
            const unsigned weights = kernel * (static_cast<unsigned>(expected) + 44);
            different +=
                lane.weights != weights || half_of(pair.weights, 0) + half_of(pair.weights, 1) != weights;
            different += lane.offs != pair.offs;
            different += static_cast<int>(lane.offs) !=
                         static_cast<int>(kernel) * (expected * (expected ? off + kReach : 0) + 44 * 44);
        }
    }
    EXPECT_EQ(different, 0);
}

// Covers every two levels of each channel, beside the extremes of the other channels.
TEST(Smoothing, KnowsColorsThatAreAlike) {
    long different = 0;
    for (int channel = 0; channel < 3; ++channel)
        for (unsigned a = 0; a < 256; ++a)
            for (unsigned b = 0; b < 256; ++b)
                for (const auto& [others_a, others_b] : {std::pair{0u, 0u},
                                                         {255u, 255u},
                                                         {0u, 20u},
                                                         {20u, 0u},
                                                         {235u, 255u},
                                                         {0u, 21u},
                                                         {255u, 0u}}) {
                    const auto color = [&](unsigned level, unsigned others) {
                        return (others * 0x010101u & ~(0xffu << (8 * channel))) | level << (8 * channel);
                    };
                    const auto far = [](unsigned x, unsigned y) {
                        return step::distance(static_cast<std::uint8_t>(x), static_cast<std::uint8_t>(y)) >
                               step::kSmoothColor;
                    };
                    const step::PlaneColor own(step::PlaneColor::packed(color(a, others_a)));
                    different += own.unlike(step::PlaneColor::packed(color(b, others_b))) !=
                                 (far(a, b) || far(others_a, others_b));
                    different += !own.unlike(step::PlaneColor::kUnknown);
                }
    EXPECT_EQ(different, 0);
}

TEST(Votes, ReachWhatIsNoLarger) {
    long different = 0;
    for (int vote = 0; vote <= INT16_MAX - 2; ++vote)
        for (const int disparity :
             {0, 1, 2, 100, 16384, vote - 1, vote, vote + 1, INT16_MAX - 2, INT16_MAX}) {
            if (disparity < 0) continue;
            const auto more = static_cast<unsigned>(vote + 2), complement = ~static_cast<unsigned>(disparity);
            const unsigned expected = vote >= disparity;
            different += step::reaching(static_cast<Lane>(more), static_cast<Lane>(complement)) != expected;
            const Pair pair = step::reaching(pair_of(more, 2), pair_of(complement, complement));
            different += half_of(pair, 0) != expected || half_of(pair, 1) != (disparity == 0);
        }
    EXPECT_EQ(different, 0);
}

TEST(Votes, HaveTheSameMedianByBitsAsByBisection) {
    std::mt19937 random(11);
    for (int k = 0; k < 20000; ++k) {
        const unsigned spread = 1u << random() % 15, first = static_cast<unsigned>(random()) % 1000;
        std::vector<std::pair<std::int16_t, std::uint16_t>> votes(1 + random() % step::kMostVotes);
        std::int16_t lo = INT16_MAX, hi = 0;
        std::uint16_t total = 0;
        for (auto& [disparity, weight] : votes) {
            disparity = static_cast<std::int16_t>(first + random() % spread);
            weight = static_cast<std::uint16_t>(random() % 3 == 0 ? 0 : random() % 193);
            if (weight == 0) continue;
            lo = std::min(lo, disparity);
            hi = std::max(hi, disparity);
            total = static_cast<std::uint16_t>(total + weight);
        }
        if (total == 0) continue;
        const auto weight_if = [&](const auto& counts) {
            unsigned sum = 0;
            for (const auto& [disparity, weight] : votes) sum += counts(disparity) ? weight : 0u;
            return sum;
        };
        const auto least = static_cast<unsigned>(lo), range = static_cast<unsigned>(hi - lo);
        unsigned highest_bit = 0;
        for (unsigned bit = 1; bit <= range; bit *= 2) highest_bit = bit;
        const unsigned by_bits = step::median_by_bits(least, highest_bit, total, [&](unsigned disparity) {
            return weight_if([&](int vote) { return vote >= static_cast<int>(disparity); });
        });
        while (lo < hi) {
            const std::int16_t middle = step::middle(lo, hi);
            step::narrow(static_cast<std::uint16_t>(weight_if([&](int vote) { return vote <= middle; })),
                         total, lo, hi);
        }
        ASSERT_EQ(by_bits, static_cast<unsigned>(lo)) << "scene " << k;
    }
}

}  // namespace
}  // namespace hexrelief::matching
