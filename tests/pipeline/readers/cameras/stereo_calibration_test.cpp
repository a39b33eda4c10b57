// Tests the calibrations of pairs that are not rectified.
#include "pipeline/readers/cameras/calibration_reader.h"
#include "tests/pipeline/readers/sample_files.h"

namespace hexrelief::readers {
namespace {

std::string matrix(const std::string& name, int rows, int columns, const std::string& data) {
    return name + ": !!opencv-matrix\n   rows: " + std::to_string(rows) +
           "\n   cols: " + std::to_string(columns) + "\n   dt: d\n   data: [ " + data + " ]\n";
}

const std::string kK1 = matrix("K1", 3, 3, "500., 0., 320., 0., 501., 240., 0., 0., 1."),
                  kD1 = matrix("D1", 1, 5, "-0.1, 0.02, 0., 0.001, 0."),
                  kK2 = matrix("K2", 3, 3, "502., 0., 322., 0., 503., 241., 0., 0., 1."),
                  kD2 = matrix("D2", 1, 5, "-0.2, 0.03, 0., 0.002, 0."),
                  kR = matrix("R", 3, 3, "1., 0., 0., 0., 1., 0., 0., 0., 1."),
                  kT = matrix("T", 3, 1, "-0.12, 0.001, 0.");
const std::string kPair = "%YAML:1.0\n---\nimage_size: [ 640, 480 ]\n" + kK1 + kD1 + kK2 + kD2 + kR + kT;
const std::string kRectified = matrix("P1", 3, 4, "500., 0., 320., 0., 0., 500., 240., 0., 0., 0., 1., 0.") +
                               matrix("P2", 3, 4, "500., 0., 320., -60., 0., 500., 240., 0., 0., 0., 1., 0.");

std::optional<StereoCalibrationFile> read(const std::string& text, Rectify rectify = Rectify::automatic) {
    const Folder folder;
    return read_stereo_calibration(folder.write("pair.yml", text), rectify);
}

std::string error_for(const std::string& text, Rectify rectify = Rectify::automatic) {
    return error_of_file("bad.yml", text, [&](const auto& path) { read_stereo_calibration(path, rectify); });
}

TEST(ReadStereoCalibration, AllOfIt) {
    const auto file = read(kPair);
    ASSERT_TRUE(file);
    const StereoCalibration& c = file->calibration;
    EXPECT_EQ(c.left.matrix, (std::array<double, 9>{500, 0, 320, 0, 501, 240, 0, 0, 1}));
    EXPECT_EQ(c.right.matrix[4], 503);
    EXPECT_EQ(c.left.distortion, (std::vector<double>{-0.1, 0.02, 0, 0.001, 0}));
    EXPECT_EQ(c.right.distortion[0], -0.2);
    EXPECT_EQ(c.rotation[4], 1);
    EXPECT_EQ(c.translation, (std::array<double, 3>{-0.12, 0.001, 0}));
    EXPECT_FALSE(c.is_fisheye);
    EXPECT_EQ(c.width, 640);
    EXPECT_TRUE(file->told.empty());
}

TEST(ReadStereoCalibration, UnderTheNamesOfOpenCvsSamples) {
    std::string text = kPair;
    for (const auto& [from, to] : {std::pair{"K1:", "M1:"}, {"K2:", "M2:"}}) text = replaced(text, from, to);
    EXPECT_TRUE(read(text));
    for (const auto& [from, to] : {std::pair{"M1:", "cameraMatrix1:"},
                                   {"M2:", "cameraMatrix2:"},
                                   {"D1:", "distCoeffs1:"},
                                   {"D2:", "distCoeffs2:"}})
        text = replaced(text, from, to);
    EXPECT_TRUE(read(text));
}

TEST(ReadStereoCalibration, RectifiedPicturesGoBefore) {
    EXPECT_TRUE(read(kPair + kRectified)->is_rectified);
    EXPECT_FALSE(read(kPair)->is_rectified);
    EXPECT_TRUE(read(kPair + kRectified, Rectify::always));
    EXPECT_FALSE(read(kPair, Rectify::never));
    EXPECT_FALSE(read("%YAML:1.0\n---\n" + kRectified));
    EXPECT_FALSE(read("cam0=[1000 0 99.5; 0 1000 49.5; 0 0 1]\nbaseline=200\ndoffs=0\n"));
    EXPECT_CONTAINS(error_for("%YAML:1.0\n---\n" + kRectified, Rectify::always), "must be there to rectify");
    const Folder folder;
    EXPECT_EQ(read_calibration_file(folder.write("both.yml", kPair + kRectified)).calibration.focal_px, 500);
    EXPECT_CONTAINS(error_of([&] { read_calibration_file(folder.write("pair.yml", kPair)); }), "rectified");
}

TEST(ReadStereoCalibration, FourNumbersAreAFisheyesUnlessTheModelIsSaid) {
    const std::string d1 = matrix("D1", 4, 1, "0.1, 0., 0., 0."), d2 = matrix("D2", 4, 1, "0., 0., 0., 0.");
    const std::string text = "%YAML:1.0\n---\n" + kK1 + d1 + kK2 + d2 + kR + kT;
    EXPECT_TRUE(read(text)->calibration.is_fisheye);
    EXPECT_EQ(read(text)->told.size(), 1u);
    EXPECT_TRUE(read(text + "model: fisheye\n")->told.empty());
    EXPECT_FALSE(read(text + "model: pinhole\n")->calibration.is_fisheye);
    EXPECT_CONTAINS(error_for(kPair + "distortion_model: equidistant\n"), "4 numbers");
}

TEST(ReadStereoCalibration, NamesTheKeyThatIsWrong) {
    EXPECT_CONTAINS(error_for(replaced(kPair, kK2, "")), "K2 is missing");
    EXPECT_CONTAINS(error_for(replaced(kPair, kD1, "")), "D1 is missing");
    EXPECT_CONTAINS(error_for(replaced(kPair, kR, "")), "R is missing");
    EXPECT_CONTAINS(error_for(replaced(kPair, kT, "")), "T is missing");
    EXPECT_CONTAINS(error_for(replaced(kPair, "500., 0.", "0., 0.")), "K1 has a focal length");
    EXPECT_CONTAINS(error_for(replaced(kPair, "500., 0.", "500.")), "K1 must hold");
    EXPECT_CONTAINS(error_for(replaced(kPair, "-0.1, 0.02", ".nan, 0.02")), "D1 is '.nan'");
    EXPECT_CONTAINS(error_for(replaced(kPair, kD1, "D1: [ 1, 2, 3 ]\n")), "D1 has 3 numbers");
    EXPECT_CONTAINS(error_for(replaced(kPair, "1., 0., 0., 0.", "1., 0.5, 0., 0.")), "R is no rotation");
    EXPECT_CONTAINS(error_for(replaced(kPair, "1., 0., 0., 0.", "-1., 0., 0., 0.")), "mirrors");
    EXPECT_CONTAINS(error_for(replaced(kPair, "-0.12, 0.001, 0.", "-0.12, 0.001")), "T must hold");
    EXPECT_CONTAINS(error_for(replaced(kPair, "[ 640, 480 ]", "[ 640, 0 ]")), "image_size");
    EXPECT_CONTAINS(error_for(replaced(kPair, "R: !!opencv-matrix", "R: [}")), "line");
}

}  // namespace
}  // namespace hexrelief::readers
