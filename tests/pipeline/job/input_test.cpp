// What a run reads is held against its limits.
#include "pipeline/job/input.h"

#include <gtest/gtest.h>

#include "pipeline/data/error.h"
#include "tests/pipeline/process.h"

namespace hexrelief::job {
namespace {

TEST(RunInput, EveryPictureAndMapIsHeldAgainstTheLimitOfPixels) {
    const test::TemporaryFolder folder;
    const std::string large = folder / "large.pgm", stereo = folder / "stereo.pgm";
    test::write_text(large, "P5\n322 240\n255\n");  // refused by its header: there is no sample
    test::write_text(stereo, "P5\n322 240\n255\n");
    const std::filesystem::path map = test::sample("disparity.pfm"), left = test::sample("left.png");
    const std::vector<Source> sources = {
        PairFiles{large, left},
        PairFiles{left, large},
        StereoFile{stereo},
        DisparityFiles{large},
        DepthFiles{large},
        DisparityFiles{map, large},
        DisparityFiles{.map = map, .mask = large},
        DisparityFiles{.map = map, .confidence = large},
    };
    config::InputConfig config;
    config.stereo.layout = readers::StereoLayout::side_by_side;
    for (std::size_t i = 0; i < sources.size(); ++i) {
        RunLog log;
        try {
            read_input(sources[i], config, {.max_pixels = 320 * 240}, 1, log);
            ADD_FAILURE() << "source " << i << " was read";
        } catch (const Error& error) {
            EXPECT_EQ(error.kind(), ErrorKind::input);
            EXPECT_NE(std::string(error.what())
                          .find("its size is 322x240, more than the limit of 76800 pixels "
                                "(limits.max_pixels)"),
                      std::string::npos)
                << i << ": " << error.what();
        }
    }
}

}  // namespace
}  // namespace hexrelief::job
