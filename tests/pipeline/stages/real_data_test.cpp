// Tests on real pairs, if the environment variable HEXRELIEF_DATA names a folder with Middlebury's data sets.
#include <gtest/gtest.h>

#include <cstdlib>
#include <ostream>

#include "pipeline/evaluation/evaluate.h"
#include "pipeline/readers/disparity_reader.h"
#include "pipeline/readers/image_reader.h"
#include "pipeline/stages/disparity.h"

namespace hexrelief::stages {
namespace {

struct RealPair {
    const char* folder;
    const char* images;  // file name extension
    const char* truth;
    double scale;
    double bad1_limit, bad2_limit;  // percent of the truth's pixels
};

void PrintTo(const RealPair& pair, std::ostream* out) {
    *out << pair.folder;
}

class RealData : public testing::TestWithParam<RealPair> {};

TEST_P(RealData, MatchesGroundTruth) {
    const char* const data = std::getenv("HEXRELIEF_DATA");
    if (data == nullptr) GTEST_SKIP() << "HEXRELIEF_DATA is not set: no real pairs to match";
    const RealPair& real = GetParam();
    const std::filesystem::path folder = std::filesystem::path(data) / real.folder;
    const StereoPair pair{readers::read_image(folder / (std::string("left.") + real.images)),
                          readers::read_image(folder / (std::string("right.") + real.images))};
    readers::DisparityFileConfig file{.scale = real.scale};
    const DisparityMap truth = readers::read_disparity_map(folder / real.truth, file);
    const evaluation::DisparityEvaluation e =
        evaluation::evaluate_disparity(compute_disparity(pair, {}, 2), truth);
    EXPECT_LT(e.bad_percent[1], real.bad1_limit);
    EXPECT_LT(e.bad_percent[2], real.bad2_limit);
}

// Limits: the measured values plus about one point.
INSTANTIATE_TEST_SUITE_P(
    Middlebury, RealData,
    testing::Values(RealPair{"middlebury2003/cones-quarter", "png", "disp.png", 4, 7.9, 6.4},
                    RealPair{"middlebury2003/teddy-quarter", "png", "disp.png", 4, 11.8, 6.9},
                    RealPair{"middlebury2006/aloe-third", "png", "disp.png", 3, 7.1, 5.1},
                    RealPair{"middlebury2006/rocks1-third", "png", "disp.png", 3, 5.4, 3.5},
                    RealPair{"middlebury2001/venus", "ppm", "disp.pgm", 8, 2.1, 1.3}));

}  // namespace
}  // namespace hexrelief::stages
