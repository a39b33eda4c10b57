// Tests that the matcher's bytes on CUDA == those on the CPU.
#include <random>

#include "cuda/cuda_matcher.h"
#include "tests/cuda/cuda_case.h"
#include "tests/cuda/made_up_pairs.h"

namespace hexrelief::testing_cuda {
namespace {

cuda::CudaMatcher& shared_matcher() {
    static cuda::CudaMatcher matcher;
    return matcher;
}

struct Case {
    const char* name;
    PairSpec pair;
    matching::DisparityRange range;
};
std::ostream& operator<<(std::ostream& out, const Case& tried) {
    return out << tried.name;
}

// Reports how many entries differ, and the position of the first.
template <typename T>
::testing::AssertionResult equal_maps(const std::vector<T>& cpu, const std::vector<T>& cuda, int width) {
    if (cpu.size() != cuda.size()) return ::testing::AssertionFailure() << "sizes differ";
    std::size_t differing = 0, first = 0;
    for (std::size_t i = cpu.size(); i-- > 0;)
        if (cpu[i] != cuda[i]) {
            ++differing;
            first = i;
        }
    if (differing == 0) return ::testing::AssertionSuccess();
    return ::testing::AssertionFailure()
           << differing << " of " << cpu.size() << " differ, the first at (" << first % width << ", "
           << first / width << "): cpu " << +cpu[first] << ", cuda " << +cuda[first];
}

void expect_equal(const PairSpec& spec, const matching::MatchingConfig& config) {
    const StereoPair pair = made_up_pair(spec);
    const matching::MatchedMap cpu = matching::match_pair(pair, config, 2),
                               cuda = shared_matcher().match_pair(pair, config);
    EXPECT_GT(shared_matcher().device_bytes(), 0u) << "the device did nothing";
    EXPECT_TRUE(equal_maps(cpu.is_matched, cuda.is_matched, spec.width));
    EXPECT_TRUE(equal_maps(cpu.disparities, cuda.disparities, spec.width))
        << spec.width << "x" << spec.height << ", " << config.range.count << " disparities from "
        << config.range.min_px << ", p1 " << config.penalties.p1 << ", p2 " << config.penalties.p2
        << ", limit " << config.consistency.left_right_limit << ", speckles "
        << config.consistency.speckle_pixels << "/" << config.consistency.speckle_step << ", channels "
        << spec.left_channels << "/" << spec.right_channels << ", seed " << spec.seed;
}

matching::MatchingConfig with_range(const matching::DisparityRange& range) {
    matching::MatchingConfig config;
    config.range = range;
    return config;
}

class MatchingEquality : public ::testing::TestWithParam<Case> {};

TEST_P(MatchingEquality, SameBytes) {
    HEXRELIEF_NEEDS_DEVICE();
    expect_equal(GetParam().pair, with_range(GetParam().range));
}

INSTANTIATE_TEST_SUITE_P(Cuda, MatchingEquality,
                         ::testing::Values(Case{"OneRow", {16, 1, 3, 3, 4, 0, 1}, {0, 8}},
                                           Case{"OneColumn", {1, 40, 3, 3, 0, 0, 1}, {0, 4}},
                                           Case{"OnePixel", {1, 1, 1, 1, 0, 0, 1}, {0, 1}},
                                           Case{"Small", {33, 17, 3, 3, 7, 1, 2}, {0, 16}},
                                           Case{"SmallGrey", {33, 17, 1, 1, 7, 1, 3}, {0, 33}},
                                           Case{"OneDisparity", {131, 77, 3, 3, 1, 1, 4}, {1, 1}},
                                           Case{"TwoDisparities", {131, 77, 3, 3, 2, 1, 4}, {1, 2}},
                                           Case{"Odd", {131, 77, 3, 3, 25, 3, 5}, {0, 33}},
                                           Case{"OddGrey", {131, 77, 1, 1, 25, 3, 6}, {0, 64}},
                                           Case{"ColorAndGrey", {131, 77, 3, 1, 25, 3, 7}, {0, 40}},
                                           Case{"GreyAndColor", {131, 77, 1, 3, 25, 3, 8}, {0, 40}},
                                           Case{"BelowZero", {131, 77, 3, 3, 12, -15, 9}, {-20, 40}},
                                           Case{"AllBelowZero", {131, 77, 3, 3, -5, -40, 10}, {-47, 45}},
                                           Case{"FarFromZero", {131, 77, 3, 3, 60, 35, 11}, {30, 50}},
                                           Case{"WiderThanThePicture", {90, 61, 3, 3, 30, 0, 12}, {-10, 200}},
                                           Case{"NothingInRange", {131, 77, 3, 3, 20, 5, 13}, {500, 16}},
                                           Case{"Tall", {67, 411, 3, 3, 20, 2, 14}, {0, 24}},
                                           Case{"LowerThanACell", {2000, 7, 3, 3, 20, 2, 25}, {0, 24}},
                                           Case{"NarrowerThanACell", {7, 2000, 3, 3, 4, 1, 26}, {0, 6}},
                                           Case{"Range65", {233, 120, 3, 3, 60, 8, 15}, {0, 65}},
                                           Case{"Range129", {233, 120, 3, 3, 60, 8, 16}, {0, 129}},
                                           Case{"Range200", {300, 120, 3, 3, 150, 20, 17}, {0, 200}},
                                           Case{"Range256", {300, 90, 3, 3, 150, 20, 18}, {-3, 256}},
                                           Case{"Range257", {300, 90, 3, 3, 150, 20, 19}, {0, 257}},
                                           Case{"Range600", {700, 60, 3, 3, 400, 20, 20}, {0, 600}},
                                           Case{"Range1100", {1300, 40, 3, 3, 900, 20, 21}, {0, 1100}},
                                           Case{"Range2047", {1300, 20, 1, 1, 900, 20, 22}, {-100, 2047}},
                                           Case{"Usual", {450, 375, 3, 3, 55, 12, 23}, {0, 64}},
                                           Case{"UsualGrey", {450, 375, 1, 1, 55, 12, 24}, {0, 64}}),
                         [](const auto& tried) { return tried.param.name; });

// Several bands of rows, because a volume of all rows would be too large; with windows in each.
TEST(CudaMatching, Bands) {
    HEXRELIEF_NEEDS_DEVICE();
    expect_equal({3300, 3400, 1, 1, 60, 5, 31}, with_range({0, 70}));
}

TEST(CudaMatching, TwoHundredSettings) {
    HEXRELIEF_NEEDS_DEVICE();
    std::mt19937 random(2027);
    const auto pick = [&](int low, int high) {
        return low + static_cast<int>(random() % static_cast<unsigned>(high - low + 1));
    };
    for (int k = 0; k < 200; ++k) {
        matching::MatchingConfig config = with_range({pick(-30, 20), k % 7 ? pick(1, 90) : pick(91, 300)});
        config.penalties.p1 = pick(0, 3) ? pick(1, 120) : pick(1, 15999);
        config.penalties.p2 = config.penalties.p1 + pick(1, pick(0, 3) ? 600 : 16000 - config.penalties.p1);
        config.penalties.p2 = std::min(config.penalties.p2, 16000);
        config.consistency.left_right_limit = pick(-1, 40);
        config.consistency.speckle_pixels = pick(0, 2) ? pick(0, 300) : 0;
        config.consistency.speckle_step = pick(0, 64);
        config.consistency.least = pick(0, 1) ? pick(0, 16 * config.range.count / 2) : 0;
        PairSpec spec{pick(1, 190),
                      pick(1, 130),
                      pick(0, 3) ? 3 : 1,
                      pick(0, 3) ? 3 : 1,
                      0,
                      0,
                      static_cast<std::uint32_t>(random())};
        spec.farthest_px = config.range.min_px + pick(-3, 3);
        spec.nearest_px = spec.farthest_px + pick(0, config.range.count);
        expect_equal(spec, config);
        if (::testing::Test::HasFailure()) return;
    }
}

TEST(CudaMatching, EveryRunGivesTheSameBytes) {
    HEXRELIEF_NEEDS_DEVICE();
    const StereoPair pair = made_up_pair({450, 375, 3, 3, 55, 12, 41});
    const matching::MatchedMap first = shared_matcher().match_pair(pair, with_range({0, 64}));
    for (int k = 0; k < 20; ++k) {
        const matching::MatchedMap again = shared_matcher().match_pair(pair, with_range({0, 64}));
        ASSERT_EQ(first.disparities, again.disparities) << "run " << k;
        ASSERT_EQ(first.is_matched, again.is_matched) << "run " << k;
    }
}

// From the second pair on launches are recorded.
TEST(CudaMatching, PairsOfOneSizeAfterEachOther) {
    HEXRELIEF_NEEDS_DEVICE();
    const auto spec = [](std::uint32_t seed) { return PairSpec{150, 90, 3, 3, 60, 9, seed}; };
    for (const int count : {64, 130}) {
        matching::MatchingConfig config = with_range({0, count});
        for (std::uint32_t seed = 61; seed < 65; ++seed) expect_equal(spec(seed), config);
        config.penalties.p1 += 7;
        for (std::uint32_t seed = 65; seed < 69; ++seed) expect_equal(spec(seed), config);
    }
}

// Run by compute-sanitizer.
TEST(CudaSmall, Matching) {
    HEXRELIEF_NEEDS_DEVICE();
    expect_equal({67, 43, 3, 3, 20, 2, 51}, with_range({-2, 30}));
    expect_equal({90, 33, 3, 1, 60, 2, 52}, with_range({0, 130}));
    expect_equal({90, 9, 3, 3, 60, 2, 53}, with_range({0, 300}));
    expect_equal({33, 5, 3, 3, 20, 2, 54}, with_range({0, 2047}));
    for (std::uint32_t seed = 55; seed < 58; ++seed)
        expect_equal({67, 43, 3, 3, 20, 2, seed}, with_range({-2, 30}));
}

}  // namespace
}  // namespace hexrelief::testing_cuda
