// Pictures and maps of others: the data of OpenCV's examples, which Debian's package opencv-doc brings.
#include <gtest/gtest.h>

#include "pipeline/checks/pair_statistics.h"
#include "pipeline/readers/image_reader.h"
#include "tests/pipeline/process.h"

namespace hexrelief::cli {
namespace {

using namespace test;

namespace fs = std::filesystem;

const fs::path kData = "/usr/share/doc/opencv-doc/examples/data";

// What a strict run on these files says against them; nothing = it meshes them.
std::string refusal_of(std::vector<std::string> options) {
    const TemporaryFolder folder;
    for (std::string& word : options)
        if (fs::exists(kData / word)) word = (kData / word).string();
    const ProcessResult result = run_program({"run", "--strict", "--report", folder / "r.json", "--fov-x",
                                              "60", "--set", "input.calibration.baseline_m=0.1"},
                                             options);
    EXPECT_EQ(result.exit_code, result.err.empty() ? 0 : 3) << result.err;
    return result.err;
}

TEST(OpenCvData, RightInputsPassAndWrongOnesAreNoticed) {
    if (!fs::exists(kData / "aloeL.jpg")) GTEST_SKIP() << "Debian's opencv-doc is not installed";
    EXPECT_EQ(refusal_of({"--left", "aloeL.jpg", "--right", "aloeR.jpg"}), "");
    EXPECT_EQ(refusal_of({"--disparity", "aloeGT.png", "--disparity-scale", "1", "--color", "aloeL.jpg"}),
              "");
    const std::string swapped = refusal_of({"--left", "aloeR.jpg", "--right", "aloeL.jpg"});
    EXPECT_CONTAINS(swapped, "swapped");
    // Taken by two cameras side by side and never rectified.
    const std::string raw =
        refusal_of({"--left", "left01.jpg", "--right", "right01.jpg", "--rectify", "never"});
    EXPECT_CONTAINS(raw, "rows differ");
}

// By cv::stereoCalibrate from the 13 pairs of the chessboard.
const char* const kChessboardCameras = R"(%YAML:1.0
---
K1: !!opencv-matrix { rows: 3, cols: 3, dt: d,
   data: [ 532.824, 0., 342.490, 0., 532.943, 233.860, 0., 0., 1. ] }
D1: !!opencv-matrix { rows: 1, cols: 5, dt: d,
   data: [ -0.280872, 0.0250976, 0.00121706, -0.000136328, 0.163663 ] }
K2: !!opencv-matrix { rows: 3, cols: 3, dt: d,
   data: [ 537.450, 0., 327.589, 0., 536.967, 248.885, 0., 0., 1. ] }
D2: !!opencv-matrix { rows: 1, cols: 5, dt: d,
   data: [ -0.297549, 0.149675, -0.000760434, 0.000324258, -0.0660160 ] }
R: !!opencv-matrix { rows: 3, cols: 3, dt: d,
   data: [ 0.999985388945, 0.00376749336, 0.00387658193, -0.00374091149, 0.999969598624, -0.00684159402,
       -0.00390223973, 0.00682699211, 0.999969081874 ] }
T: !!opencv-matrix { rows: 3, cols: 1, dt: d,
   data: [ -0.0831996, 0.000931301, 0.000361509 ] }
image_width: 640
image_height: 480
)";

TEST(OpenCvData, AnUnrectifiedPairIsRectifiedByItsCalibration) {
    if (!fs::exists(kData / "left01.jpg")) GTEST_SKIP() << "Debian's opencv-doc is not installed";
    const TemporaryFolder folder;
    write_text(folder / "stereo.yml", kChessboardCameras);
    expect_success({"run", "--strict", "--quiet", "--left", kData / "left01.jpg", "--right",
                    kData / "right01.jpg", "--calib", folder / "stereo.yml", "-o", folder / "o.glb",
                    "--save-stages", folder / "stages"});
    const StereoPair pair{readers::read_image(folder / "stages/left_rectified.png"),
                          readers::read_image(folder / "stages/right_rectified.png")};
    const checks::RowFit rows = checks::measure_rows(pair, stages::match_coarsely(pair, 0, 1), 1);
    EXPECT_GE(rows.points, 20);
    EXPECT_LT(rows.largest_px, 0.5);
}

}  // namespace
}  // namespace hexrelief::cli
