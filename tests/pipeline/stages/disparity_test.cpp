#include "pipeline/stages/disparity.h"
#include "pipeline/evaluation/evaluate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "pipeline/readers/disparity_reader.h"
#include "pipeline/readers/image_reader.h"
#include "tests/expect_error.h"

namespace hexrelief::stages {
namespace {

// Limits: measured values plus a margin. Most bad pixels are hidden in the right view and correctly unknown.
constexpr double kBad1Limit_percent = 6, kWrong2Limit_percent = 3.2, kAverageLimit_px = 0.75;

struct Sample {
    StereoPair pair;
    DisparityMap disparity;
};

const Sample& sample() {
    static const std::filesystem::path folder = std::filesystem::path(HEXRELIEF_SOURCE_DIR) / "samples";
    static const Sample files{
        {readers::read_image(folder / "left.png"), readers::read_image(folder / "right.png")},
        readers::read_disparity_map(folder / "disparity.pfm", {})};
    return files;
}

// Returns a grey pair of random texture, the right view shifted by `shift` px everywhere.
StereoPair shifted_pair(int width, int height, int shift) {
    StereoPair pair;
    pair.left = pair.right =
        Image{width, height, 1, std::vector<std::uint8_t>(static_cast<std::size_t>(width) * height)};
    const auto texture = [](int x, int y) {
        std::uint32_t h =
            static_cast<std::uint32_t>(x + 1000) * 0x9e3779b1u ^ static_cast<std::uint32_t>(y) * 0x85ebca6bu;
        h = (h ^ (h >> 15)) * 0x2c1b3c6du;
        return static_cast<std::uint8_t>((h ^ (h >> 13)) >> 8);
    };
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            *pair.left.at(x, y) = texture(x, y);
            *pair.right.at(x, y) = texture(x + shift, y);
        }
    return pair;
}

// Returns the truth without pixels that another surface hides in the right view or that lie outside it, since
// they have no match.
DisparityMap visible_truth() {
    DisparityMap truth = sample().disparity;
    for (int y = 0; y < truth.height; ++y)
        for (int x = 0; x < truth.width; ++x) {
            const float match = x - truth.at(x, y);
            bool hidden = match < 0;
            for (int other = x + 1; other < truth.width && !hidden; ++other) {
                const float d = sample().disparity.at(other, y);
                hidden = d > sample().disparity.at(x, y) + 1 && other - d < match + 1;
            }
            if (hidden) truth.at(x, y) = kUnknownDisparity;
        }
    return truth;
}

double share_at(const DisparityMap& map, int from, int to, float value) {
    long long good = 0;
    for (int y = 0; y < map.height; ++y)
        for (int x = from; x < to; ++x) good += std::abs(map.at(x, y) - value) <= 0.25f;
    return static_cast<double>(good) / map.height / (to - from);
}

// Returns the configuration of plain StereoSGBM, without the refinement.
DisparityConfig sgbm() {
    return {.method = DisparityMethod::sgbm, .fill = DisparityFill::none};
}

TEST(Disparity, FindsTheSampleScene) {
    const DisparityMap map = compute_disparity(sample().pair, {}, 2);
    const evaluation::DisparityEvaluation e = evaluation::evaluate_disparity(map, sample().disparity);
    EXPECT_LT(e.bad_percent[1], 8);
    EXPECT_LT(e.bad_percent[2], 6);
    EXPECT_EQ(e.coverage_percent, 100);
    ASSERT_EQ(map.origins.size(), map.values.size());
    EXPECT_GT(std::count(map.origins.begin(), map.origins.end(), PixelOrigin::matched),
              0.8 * static_cast<double>(map.origins.size()));
    EXPECT_EQ(std::count(map.origins.begin(), map.origins.end(), PixelOrigin::unknown), 0);
}

TEST(Disparity, FillsNothingUnlessAsked) {
    DisparityConfig config;
    const DisparityMap filled = compute_disparity(sample().pair, config, 2);
    config.fill = DisparityFill::none;
    const DisparityMap open = compute_disparity(sample().pair, config, 2);
    for (std::size_t i = 0; i < open.values.size(); ++i) {
        const bool is_matched = filled.origins[i] == PixelOrigin::matched;
        ASSERT_EQ(DisparityMap::known(open.values[i]), is_matched);
        ASSERT_EQ(open.origins[i], is_matched ? PixelOrigin::matched : PixelOrigin::unknown);
        if (is_matched) {
            ASSERT_EQ(open.values[i], filled.values[i]);
        }
    }
}

TEST(Disparity, IsNearlyAsGoodWhereTheLightDiffers) {
    StereoPair pair = sample().pair;
    for (std::uint8_t& level : pair.right.pixels)
        level = static_cast<std::uint8_t>(std::lround(204 * std::pow(level / 255.0, 1.4)));
    const auto bad = [](const DisparityMap& map) {
        return evaluation::evaluate_disparity(map, sample().disparity).bad_percent[1];
    };
    CpuMatcher on_cpu(2);
    const DisparityConfig ranged = find_range(pair, {}, {}, 2).config;
    const double same = bad(compute_disparity(sample().pair, {}, 2));
    const double other = bad(compute_disparity(pair, ranged, 2));
    const double as_it_is = bad(match_range(pair, ranged, on_cpu, 2));
    RecordProperty("bad1",
                   std::to_string(same) + " " + std::to_string(other) + " " + std::to_string(as_it_is));
    EXPECT_LT(other - same, (as_it_is - same) / 2);
}

TEST(Disparity, NoiseIsAveragedOut) {
    StereoPair pair = sample().pair;
    std::uint32_t state = 1;
    for (Image* image : {&pair.left, &pair.right})
        for (std::uint8_t& level : image->pixels) {
            int sum = 0;  // sum of four: a standard deviation of 18 levels
            for (int i = 0; i < 4; ++i)
                sum += static_cast<int>((state = state * 1664525u + 1013904223u) >> 24) % 31;
            level = static_cast<std::uint8_t>(std::clamp(level + sum - 60, 0, 255));
        }
    const FoundRange ranged = find_range(pair, {}, {}, 2);
    EXPECT_GT(ranged.correction.left_noise, 6);
    EXPECT_GT(ranged.correction.right_noise, 6);
    CpuMatcher on_cpu(2);
    const auto bad = [&](const PairCorrection& correction) {
        return evaluation::evaluate_disparity(
                   match_range(corrected(pair, correction, 2), ranged.config, on_cpu, 2), sample().disparity)
            .bad_percent[2];
    };
    RecordProperty("bad2", std::to_string(bad(ranged.correction)) + " " + std::to_string(bad({})));
    EXPECT_LT(bad(ranged.correction), 0.95 * bad({}));
}

TEST(Disparity, StereoSgbmFindsTheSampleScene) {
    const evaluation::DisparityEvaluation e =
        evaluation::evaluate_disparity(compute_disparity(sample().pair, sgbm(), 2), visible_truth());
    RecordProperty("bad1", std::to_string(e.bad_percent[1]));
    RecordProperty("coverage", std::to_string(e.coverage_percent));
    EXPECT_LT(e.bad_percent[1], kBad1Limit_percent);
    EXPECT_LT(e.bad_percent[2] - (100 - e.coverage_percent),
              kWrong2Limit_percent);  // known but wrong
    EXPECT_LT(e.average_error_px, kAverageLimit_px);
}

Image upper_rows(const Image& image, int rows) {
    Image result{image.width, rows, image.channels, image.pixels};
    result.pixels.resize(static_cast<std::size_t>(image.width) * rows * image.channels);
    return result;
}

TEST(Disparity, IsTheSameForAnyNumberOfThreads) {
    const StereoPair pair{upper_rows(sample().pair.left, 64), upper_rows(sample().pair.right, 64)};
    const auto expect_same = [&](const DisparityConfig& config) {
        const DisparityMap one = compute_disparity(pair, config, 1);
        EXPECT_EQ(one.values, compute_disparity(pair, config, 2).values);
        EXPECT_EQ(one.values, compute_disparity(pair, config, 5).values);
    };
    expect_same({});
    for (const SgbmMode mode : {SgbmMode::sgbm, SgbmMode::hh, SgbmMode::sgbm_3way, SgbmMode::hh4}) {
        DisparityConfig config = sgbm();
        config.mode = mode;
        expect_same(config);
        config.fill = DisparityFill::planes;
        expect_same(config);
    }
}

TEST(Disparity, KeepsTheLeftBand) {
    const int shift = 20;
    const StereoPair pair = shifted_pair(200, 60, shift);
    const DisparityMap map = compute_disparity(pair, sgbm(), 1);
    EXPECT_GT(share_at(compute_disparity(pair, {}, 1), 0, 64, shift), 0.94);  // filled beyond the frame
    // Matched, although the search range is wider than x.
    EXPECT_GT(share_at(map, shift + 2, 64, shift), 0.97);
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x + 1 < shift; ++x)
            EXPECT_TRUE(!DisparityMap::known(map.at(x, y)) || map.at(x, y) <= x + 1)
                << "outside the right image";
}

TEST(Disparity, ChoosesARangeThatHoldsTheScene) {
    for (const int shift : {2, 30, 90, 150}) {
        const DisparityMap map = compute_disparity(shifted_pair(320, 120, shift), {}, 1);
        EXPECT_GT(share_at(map, shift + 3, 318, static_cast<float>(shift)), 0.95) << shift;
    }
}

TEST(Disparity, TakesAGivenRange) {
    DisparityConfig config{.min_disparity_px = 16};
    config.num_disparities_px = 30;  // rounded up to 32
    const StereoPair pair = shifted_pair(200, 60, 46);
    EXPECT_GT(share_at(compute_disparity(pair, config, 1), 50, 198, 46), 0.95);
    config.num_disparities_px = 16;
    EXPECT_EQ(share_at(compute_disparity(pair, config, 1), 50, 198, 46), 0);
}

TEST(Disparity, TakesARangeAsWideAsThePictures) {
    const StereoPair pair = shifted_pair(200, 60, 46);  // 208 px when rounded up
    for (const int count : {0, 199, 200}) {
        DisparityConfig config{.num_disparities_px = count};
        EXPECT_GT(share_at(compute_disparity(pair, config, 1), 50, 198, 46), 0.95) << count;
    }
    EXPECT_EQ(compute_disparity(shifted_pair(20, 40, 3), {}, 1).width, 20);
}

TEST(Disparity, FindsNegativeDisparities) {
    DisparityConfig config{.min_disparity_px = -32, .num_disparities_px = 64};
    EXPECT_GT(share_at(compute_disparity(shifted_pair(200, 60, -9), config, 1), 2, 188, -9), 0.95);
}

TEST(Disparity, LeavesUnknownWhatTheRightViewDoesNotShow) {
    const DisparityMap map = compute_disparity(sample().pair, sgbm(), 1);
    DisparityConfig config = sgbm();
    config.left_right_check_px = -1;
    const DisparityMap unchecked = compute_disparity(sample().pair, config, 1);
    const auto unknown = [](const DisparityMap& m) {
        return std::count(m.values.begin(), m.values.end(), kUnknownDisparity);
    };
    EXPECT_GT(unknown(map), 2 * unknown(unchecked));
    for (const float d : map.values) EXPECT_FALSE(std::isnan(d));
}

// A scene at 40 px, and a patch that both views show 2 px apart, because different surfaces seen by the two
// cameras may look alike.
TEST(Disparity, DropsSmallPatchesBeyondTheScene) {
    constexpr int kScene_px = 40, kPatch_px = 2;
    StereoPair pair = shifted_pair(800, 200, kScene_px);
    const StereoPair other = shifted_pair(900, 200, 0);
    for (int y = 100; y < 108; ++y)
        for (int x = 500; x < 524; ++x)
            *pair.left.at(x, y) = *pair.right.at(x - kPatch_px, y) = *other.left.at(x + 300, y);
    const auto least_of = [&](const DisparityConfig& config) {
        const DisparityMap map = compute_disparity(pair, config, 2);
        return *std::min_element(map.values.begin(), map.values.end());
    };
    DisparityConfig config;
    const double farthest_px = find_range(pair, {}, config, 2).config.farthest_px;
    EXPECT_GT(farthest_px, 20);
    EXPECT_LT(farthest_px, kScene_px);
    EXPECT_GT(least_of(config), kScene_px - 3);
    config.farthest_px = 0;
    EXPECT_NEAR(least_of(config), kPatch_px, 1);
    config.farthest_px = kScene_px + 10;  // the scene is no small patch
    EXPECT_EQ(find_range(pair, {}, config, 2).config.farthest_px, kScene_px + 10);
    EXPECT_GT(share_at(compute_disparity(pair, config, 2), 50, 450, kScene_px), 0.95);
}

TEST(Disparity, MatchesGreyWithColour) {
    StereoPair pair = sample().pair;
    Image grey{pair.right.width, pair.right.height, 1, {}};
    for (std::size_t i = 0; i < pair.right.pixels.size(); i += 3) {
        const std::uint8_t* const p = pair.right.pixels.data() + i;
        grey.pixels.push_back(static_cast<std::uint8_t>(0.299 * p[0] + 0.587 * p[1] + 0.114 * p[2] + 0.5));
    }
    pair.right = grey;
    DisparityConfig config = sgbm();
    config.color = true;  // impossible with one grey image
    EXPECT_LT(
        evaluation::evaluate_disparity(compute_disparity(pair, {}, 1), sample().disparity).bad_percent[1], 8);
    EXPECT_LT(
        evaluation::evaluate_disparity(compute_disparity(pair, config, 1), visible_truth()).bad_percent[1],
        kBad1Limit_percent);
}

TEST(Disparity, StereoSgbmWorksInColour) {
    DisparityConfig config = sgbm();
    config.color = true;
    const DisparityMap colour = compute_disparity(sample().pair, config, 1);
    EXPECT_NE(colour.values, compute_disparity(sample().pair, sgbm(), 1).values);
    EXPECT_LT(evaluation::evaluate_disparity(colour, visible_truth()).bad_percent[1],
              1.3 * kBad1Limit_percent);
}

TEST(Disparity, SurvivesTheSmallestAndEmptiestImages) {
    std::vector<DisparityConfig> configs(5, sgbm());
    for (std::size_t i = 0; i < 4; ++i) configs[i].mode = static_cast<SgbmMode>(i);
    configs[4] = DisparityConfig{};
    for (const DisparityConfig& config : configs)
        for (const int height : {1, 2, 3, 5, 17}) {
            StereoPair pair = shifted_pair(16, height, 2);
            EXPECT_EQ(compute_disparity(pair, config, 2).values.size(), std::size_t{16} * height);
            std::fill(pair.left.pixels.begin(), pair.left.pixels.end(), std::uint8_t{128});
            pair.right.pixels = pair.left.pixels;
            EXPECT_EQ(compute_disparity(pair, config, 2).values.size(), std::size_t{16} * height);
        }
}

TEST(Disparity, RefusesWhatDoesNotFit) {
    StereoPair pair = shifted_pair(64, 16, 2);
    pair.right = shifted_pair(60, 16, 2).right;
    EXPECT_CONTAINS(test::error_of([&] { compute_disparity(pair, {}, 1); }), "64x16");
    EXPECT_CONTAINS(test::error_of([] { compute_disparity(shifted_pair(15, 16, 0), {}, 1); }), "16 columns");
    const int too_long = kLargestPairSide_px + 1;
    for (const DisparityMethod method : {DisparityMethod::sgm, DisparityMethod::sgbm}) {
        DisparityConfig config{.method = method};
        EXPECT_CONTAINS(test::error_of([&] { compute_disparity(shifted_pair(too_long, 1, 2), config, 1); }),
                        "32766 px");
        EXPECT_CONTAINS(test::error_of([&] { compute_disparity(shifted_pair(16, too_long, 2), config, 1); }),
                        "32766 px");
    }
    pair = shifted_pair(64, 16, 2);
    const auto refuses = [&](const std::string& part, auto change) {
        DisparityConfig config;
        change(config);
        EXPECT_CONTAINS(test::error_of([&] { compute_disparity(pair, config, 1); }, ErrorKind::usage), part);
    };
    refuses("wider than the image", [](DisparityConfig& c) { c.num_disparities_px = 65; });
    refuses("block_size_px", [](DisparityConfig& c) { c.block_size_px = 4; });
    refuses("pre_filter_cap", [](DisparityConfig& c) { c.pre_filter_cap = 200; });
    refuses("uniqueness_ratio_percent", [](DisparityConfig& c) { c.uniqueness_ratio_percent = 101; });
    refuses("min_disparity_px", [](DisparityConfig& c) { c.min_disparity_px = 64; });
    refuses("speckle_range_px", [](DisparityConfig& c) { c.speckle_range_px = -1; });
    refuses("p2", [](DisparityConfig& c) { c.p1 = 900, c.p2 = 800; });
}

}  // namespace
}  // namespace hexrelief::stages
