// Pictures and maps of others: the data of OpenCV's examples, which Debian's package opencv-doc brings.
#include <gtest/gtest.h>

#include "tests/pipeline/process.h"

namespace hexrelief::test {
namespace {

namespace fs = std::filesystem;

const fs::path kData = "/usr/share/doc/opencv-doc/examples/data";

// What a strict run on these files says against them; nothing = it meshes them.
std::string refusal_of(std::vector<std::string> options) {
    const TemporaryFolder folder;
    for (std::string& word : options)
        if (fs::exists(kData / word)) word = (kData / word).string();
    std::vector<std::string> arguments = {
        "run",     "--strict", "--report", folder / "r.json",
        "--fov-x", "60",       "--set",    "input.calibration.baseline_m=0.1"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const ProcessResult result = run_program(arguments);
    EXPECT_EQ(result.exit_code, result.err.empty() ? 0 : 3) << result.err;
    return result.err;
}

TEST(OpenCvData, RightInputsPassAndWrongOnesAreNoticed) {
    if (!fs::exists(kData / "aloeL.jpg")) GTEST_SKIP() << "Debian's opencv-doc is not installed";
    EXPECT_EQ(refusal_of({"--left", "aloeL.jpg", "--right", "aloeR.jpg"}), "");
    EXPECT_EQ(refusal_of({"--disparity", "aloeGT.png", "--disparity-scale", "1", "--color", "aloeL.jpg"}),
              "");
    const std::string swapped = refusal_of({"--left", "aloeR.jpg", "--right", "aloeL.jpg"});
    EXPECT_NE(swapped.find("swapped"), std::string::npos) << swapped;
    // Taken by two cameras side by side and never rectified.
    const std::string raw = refusal_of({"--left", "left01.jpg", "--right", "right01.jpg"});
    EXPECT_NE(raw.find("rows differ"), std::string::npos) << raw;
}

}  // namespace
}  // namespace hexrelief::test
