// The calibration in effect.
#include <gtest/gtest.h>

#include "pipeline/data/error.h"
#include "pipeline/job/cameras/resolve_calibration.h"
#include "tests/pipeline/process.h"

namespace hexrelief::job {
namespace {

ResolvedCalibration resolve(const config::CalibrationConfig& config, ViewSize view, ViewSize picture = {}) {
    return resolve_calibration({config, view, picture.width > 0 ? picture : view});
}

TEST(ResolveCalibration, NothingGivenIsRelativeWithOneWarning) {
    const ResolvedCalibration resolved = resolve({}, {640, 480});
    const Calibration& camera = resolved.calibration;
    EXPECT_FALSE(camera.metric);
    EXPECT_EQ(camera.focal_px, 640);
    EXPECT_EQ(camera.baseline_m, 1);
    EXPECT_EQ(camera.cx, 320);
    EXPECT_EQ(camera.cy, 240);
    EXPECT_EQ(camera.doffs_px, 0);
    EXPECT_TRUE(resolved.warnings.empty());
    EXPECT_CONTAINS(missing_for_metres(resolved), "relative");
}

TEST(ResolveCalibration, ExplicitLengthsAreMetric) {
    config::CalibrationConfig config{.focal_px = 3740, .baseline_m = 0.16, .cx = 641.5, .doffs_px = 270};
    const ResolvedCalibration resolved = resolve(config, {1282, 1110});
    const Calibration& camera = resolved.calibration;
    EXPECT_TRUE(camera.metric);
    EXPECT_EQ(camera.cx, 641.5);
    EXPECT_EQ(camera.cy, 555);
    EXPECT_EQ(camera.doffs_px, 270);
    EXPECT_TRUE(resolved.warnings.empty());
    EXPECT_EQ(missing_for_metres(resolved), "");
}

TEST(ResolveCalibration, APhotographsOwnCameraIsTakenUnlessAFileIsGiven) {
    Calibration own{.focal_px = 150, .cx = 90, .cy = 60, .baseline_m = 0.02, .doffs_px = 2};
    const auto resolved_with = [&](const config::CalibrationConfig& config) {
        return resolve_calibration({config, {200, 100}, {200, 100}, nullptr, {}, &own});
    };
    const ResolvedCalibration alone = resolved_with({});
    EXPECT_TRUE(alone.calibration.metric);
    EXPECT_EQ(alone.calibration.focal_px, 150);
    EXPECT_EQ(alone.calibration.cx, 90);
    EXPECT_EQ(alone.calibration.doffs_px, 2);
    EXPECT_EQ(alone.focal_from, kOwnCamera);
    EXPECT_EQ(alone.baseline_from, kOwnCamera);
    config::CalibrationConfig config{.baseline_m = 0.1};
    EXPECT_EQ(resolved_with(config).calibration.baseline_m, 0.1);
    EXPECT_EQ(resolved_with(config).calibration.focal_px, 150);
    const test::TemporaryFolder folder;
    test::write_text(folder / "K.txt", "100 0 100\n0 100 50\n0 0 1\n");
    config.file = folder / "K.txt";
    EXPECT_EQ(resolved_with(config).calibration.focal_px, 100);
    EXPECT_EQ(resolved_with(config).calibration.doffs_px, 0);
}

TEST(ResolveCalibration, ExplicitValuesOverrideTheFile) {
    const test::TemporaryFolder folder;
    test::write_text(folder / "calib.txt",
                     "cam0=[1000 0 99.5; 0 1000 49.5; 0 0 1]\ncam1=[1000 0 99.5; 0 1000 49.5; 0 0 1]\n"
                     "doffs=5\nbaseline=200\nwidth=200\nheight=100\n");
    config::CalibrationConfig config{.file = folder / "calib.txt", .doffs_px = 7};
    const ResolvedCalibration resolved = resolve(config, {200, 100});
    const Calibration& camera = resolved.calibration;
    EXPECT_EQ(camera.focal_px, 1000);
    EXPECT_DOUBLE_EQ(camera.baseline_m, 0.2);
    EXPECT_EQ(camera.cx, 100);
    EXPECT_EQ(camera.doffs_px, 7);
    EXPECT_TRUE(camera.metric);
}

TEST(ResolveCalibration, AnotherSizeIsScaledOrAnErrorNamingBoth) {
    const test::TemporaryFolder folder;
    test::write_text(folder / "calib.txt",
                     "cam0=[1000 0 99.5; 0 1000 49.5; 0 0 1]\ncam1=[1000 0 99.5; 0 1000 49.5; 0 0 1]\n"
                     "doffs=5\nbaseline=200\nwidth=200\nheight=100\n");
    config::CalibrationConfig config{.file = folder / "calib.txt"};
    EXPECT_EQ(resolve(config, {400, 200}).calibration.focal_px, 2000);
    EXPECT_CONTAINS(resolve(config, {400, 200}).decisions.at(0), "200x100");
    const std::string message = test::error_of([&] { resolve(config, {400, 300}); });
    EXPECT_CONTAINS(message, "200x100");
    EXPECT_CONTAINS(message, "400x300");
}

TEST(ResolveCalibration, PrincipalPointFarOutsideIsAnError) {
    config::CalibrationConfig config{.focal_px = 3740, .baseline_m = 0.16, .cx = 5000};
    EXPECT_THROW(resolve(config, {640, 480}), Error);
}

TEST(ResolveCalibration, AFocalLengthAloneIsRelative) {
    config::CalibrationConfig config{.fov_x_deg = 90};
    const ResolvedCalibration resolved = resolve(config, {640, 480});
    EXPECT_NEAR(resolved.calibration.focal_px, 320, 1e-9);
    EXPECT_EQ(resolved.calibration.baseline_m, 1);
    EXPECT_FALSE(resolved.calibration.metric);
    EXPECT_TRUE(resolved.is_focal_known);
    EXPECT_FALSE(resolved.is_baseline_known);
    EXPECT_CONTAINS(missing_for_metres(resolved), "baseline");
    config.baseline_m = 0.1;
    EXPECT_TRUE(resolve(config, {640, 480}).calibration.metric);
    config.fov_x_deg = config::kNotGiven;
    EXPECT_CONTAINS(missing_for_metres(resolve(config, {640, 480})), "focal length");
}

TEST(ResolveCalibration, ACameraOfThePictureIsScaledToTheMap) {
    const test::TemporaryFolder folder;
    config::CalibrationConfig config{.file = folder / "camera"};
    // The centre of pixel 99 of 200 lies at 99.5 from the edge, so at 49.75 of 100.
    test::write_text(folder / "camera", "{fx: 100, fy: 100, cx: 99, cy: 49, width: 200, height: 100}");
    const ResolvedCalibration resolved = resolve(config, {100, 50}, {200, 100});
    EXPECT_EQ(resolved.calibration.focal_px, 50);
    EXPECT_EQ(resolved.calibration.cx, 49.75);
    EXPECT_EQ(resolved.calibration.cy, 24.75);
    EXPECT_EQ(resolved.calibration.width, 100);
    ASSERT_EQ(resolved.decisions.size(), 1u);
    EXPECT_CONTAINS(resolved.decisions[0], "200x100");
    EXPECT_EQ(resolve(config, {100, 50}).calibration.cx, 49.75);
    EXPECT_THROW(resolve(config, {100, 60}), Error);
    EXPECT_THROW(resolve(config, {100, 60}, {400, 240}), Error);

    // Without a size it is of the one in whose middle it looks.
    test::write_text(folder / "camera", "100 0 99\n0 100 49\n0 0 1\n");
    EXPECT_EQ(resolve(config, {100, 50}, {200, 100}).calibration.cx, 49.75);
    EXPECT_EQ(resolve(config, {200, 100}, {400, 200}).calibration.cx, 99.5);
    EXPECT_EQ(resolve(config, {200, 100}).calibration.cx, 99.5);
}

TEST(ResolveCalibration, APrincipalPointTellsAnotherSize) {
    const test::TemporaryFolder folder;
    config::CalibrationConfig config{.file = folder / "K.txt"};
    test::write_text(folder / "K.txt", "700 0 317.5\n0 700 243.5\n0 0 1\n");
    const ResolvedCalibration half = resolve(config, {320, 240});
    EXPECT_EQ(half.calibration.focal_px, 350);
    EXPECT_EQ(half.calibration.cx, 159);
    ASSERT_EQ(half.warnings.size(), 1u);
    EXPECT_CONTAINS(half.warnings[0], "640x480");
    const ResolvedCalibration large = resolve(config, {1920, 1440});
    EXPECT_EQ(large.calibration.focal_px, 2100);
    EXPECT_CONTAINS(large.warnings.at(0), "640x480");
    // A principal point that may be the picture's own, or of no picture of the aspect, is believed.
    EXPECT_TRUE(resolve(config, {640, 480}).warnings.empty());
    EXPECT_TRUE(resolve(config, {800, 500}).warnings.empty());
    EXPECT_EQ(resolve(config, {320, 480}).calibration.focal_px, 700);
    EXPECT_CONTAINS(resolve(config, {320, 480}).warnings.at(0), "far off the middle");
    EXPECT_EQ(resolve(config, {960, 720}).calibration.focal_px, 1050);
    config.cx = 318;
    config.cy = 244;
    EXPECT_EQ(resolve(config, {320, 240}).calibration.focal_px, 700);
    EXPECT_TRUE(resolve(config, {320, 240}).warnings.empty());
}

TEST(CameraText, SaysWhereItsLengthsAreFrom) {
    const std::string text = camera_text({}, "by the points that both pictures show", "not known");
    EXPECT_CONTAINS(text, "; focal: by the points that both pictures show, baseline: not known");
}

TEST(SameAspect, RoundsToAPixel) {
    EXPECT_TRUE(same_aspect({640, 480}, {640, 480}));
    EXPECT_TRUE(same_aspect({518, 389}, {4000, 3000}));
    EXPECT_TRUE(same_aspect({4000, 3000}, {518, 389}));
    EXPECT_FALSE(same_aspect({518, 392}, {4000, 3000}));
    EXPECT_FALSE(same_aspect({640, 480}, {480, 640}));
}

}  // namespace
}  // namespace hexrelief::job
