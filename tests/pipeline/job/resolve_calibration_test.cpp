// The calibration in effect.
#include <gtest/gtest.h>

#include "pipeline/data/error.h"
#include "pipeline/job/resolve_calibration.h"
#include "tests/pipeline/process.h"

namespace hexrelief {
namespace {

TEST(ResolveCalibration, NothingGivenIsRelativeWithOneWarning) {
    std::vector<std::string> warnings;
    const Calibration camera = resolve_calibration({}, 640, 480, warnings);
    EXPECT_FALSE(camera.metric);
    EXPECT_EQ(camera.focal_px, 640);
    EXPECT_EQ(camera.baseline_m, 1);
    EXPECT_EQ(camera.cx, 320);
    EXPECT_EQ(camera.cy, 240);
    EXPECT_EQ(camera.doffs_px, 0);
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_NE(warnings[0].find("relative"), std::string::npos);
}

TEST(ResolveCalibration, ExplicitLengthsAreMetric) {
    CalibrationConfig config;
    config.focal_px = 3740;
    config.baseline_m = 0.16;
    config.doffs_px = 270;
    config.cx = 641.5;
    std::vector<std::string> warnings;
    const Calibration camera = resolve_calibration(config, 1282, 1110, warnings);
    EXPECT_TRUE(camera.metric);
    EXPECT_EQ(camera.cx, 641.5);
    EXPECT_EQ(camera.cy, 555);
    EXPECT_EQ(camera.doffs_px, 270);
    EXPECT_TRUE(warnings.empty());
}

TEST(ResolveCalibration, ExplicitValuesOverrideTheFile) {
    const test::TemporaryFolder folder;
    test::write_text(folder / "calib.txt",
                     "cam0=[1000 0 99.5; 0 1000 49.5; 0 0 1]\ncam1=[1000 0 99.5; 0 1000 49.5; 0 0 1]\n"
                     "doffs=5\nbaseline=200\nwidth=200\nheight=100\n");
    CalibrationConfig config;
    config.file = folder / "calib.txt";
    config.doffs_px = 7;
    std::vector<std::string> warnings;
    const Calibration camera = resolve_calibration(config, 200, 100, warnings);
    EXPECT_EQ(camera.focal_px, 1000);
    EXPECT_DOUBLE_EQ(camera.baseline_m, 0.2);
    EXPECT_EQ(camera.cx, 100);
    EXPECT_EQ(camera.doffs_px, 7);
    EXPECT_TRUE(camera.metric);
}

TEST(ResolveCalibration, AnotherSizeIsAnErrorNamingBoth) {
    const test::TemporaryFolder folder;
    test::write_text(folder / "calib.txt",
                     "cam0=[1000 0 99.5; 0 1000 49.5; 0 0 1]\ncam1=[1000 0 99.5; 0 1000 49.5; 0 0 1]\n"
                     "doffs=5\nbaseline=200\nwidth=200\nheight=100\n");
    CalibrationConfig config;
    config.file = folder / "calib.txt";
    std::vector<std::string> warnings;
    try {
        resolve_calibration(config, 400, 200, warnings);
        FAIL() << "no error";
    } catch (const Error& e) {
        EXPECT_EQ(e.kind(), ErrorKind::input);
        EXPECT_NE(std::string(e.what()).find("200x100"), std::string::npos);
        EXPECT_NE(std::string(e.what()).find("400x200"), std::string::npos);
    }
}

TEST(ResolveCalibration, PrincipalPointFarOutsideIsAnError) {
    CalibrationConfig config;
    config.focal_px = 3740;
    config.baseline_m = 0.16;
    config.cx = 5000;
    std::vector<std::string> warnings;
    EXPECT_THROW(resolve_calibration(config, 640, 480, warnings), Error);
}

}  // namespace
}  // namespace hexrelief
