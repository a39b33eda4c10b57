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
    using Files = std::vector<std::pair<std::filesystem::path RunRequest::*, std::filesystem::path>>;
    const std::vector<Files> requests = {
        {{&RunRequest::left, large}, {&RunRequest::right, left}},
        {{&RunRequest::left, left}, {&RunRequest::right, large}},
        {{&RunRequest::stereo, stereo}},
        {{&RunRequest::disparity, large}},
        {{&RunRequest::depth, large}},
        {{&RunRequest::disparity, map}, {&RunRequest::color, large}},
        {{&RunRequest::disparity, map}, {&RunRequest::mask, large}},
        {{&RunRequest::disparity, map}, {&RunRequest::confidence, large}},
    };
    for (std::size_t i = 0; i < requests.size(); ++i) {
        RunRequest request;
        for (const auto& [member, file] : requests[i]) request.*member = file;
        request.config.limits.reading.max_pixels = 320 * 240;
        request.config.input.stereo.layout = readers::StereoLayout::side_by_side;
        const RunObserver observer;
        RunLog log(observer);
        try {
            read_input(request, 1, log);
            ADD_FAILURE() << "request " << i << " was read";
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
