// Tests the formats of single cameras: matrices, ROS, Open3D, RealSense, COLMAP.
#include "pipeline/readers/cameras/calibration_reader.h"
#include "tests/pipeline/readers/sample_files.h"

namespace hexrelief::readers {
namespace {

CalibrationFile read(std::string_view text) {
    const Folder folder;
    return read_calibration_file(folder.write("camera", text));
}

std::string error_for(std::string_view text) {
    return error_of_file("bad.txt", text, [](const auto& path) { read_calibration_file(path); });
}

struct Expected {
    double focal, cx, cy;
    int width = 0, height = 0;
    double baseline_m = 0;
};

void expect_camera(std::string_view text, const std::string& format, const Expected& expected) {
    const CalibrationFile file = read(text);
    const Calibration& c = file.calibration;
    EXPECT_EQ(file.format, format) << text;
    EXPECT_NEAR(c.focal_px, expected.focal, 1e-9) << text;
    EXPECT_NEAR(c.cx, expected.cx, 1e-9) << text;
    EXPECT_NEAR(c.cy, expected.cy, 1e-9) << text;
    EXPECT_EQ(c.width, expected.width) << text;
    EXPECT_EQ(c.height, expected.height) << text;
    EXPECT_NEAR(c.baseline_m, expected.baseline_m, 1e-12) << text;
    EXPECT_EQ(c.metric, expected.baseline_m > 0) << text;
}

TEST(ReadCameraMatrix, AsTextAndJson) {
    const Expected camera{700, 320.5, 240.5};
    expect_camera("700 0 320\n0 700 240\n0 0 1\n", "camera matrix", camera);
    expect_camera("7.000e+02 0.0 3.2e+02 0.0 7e2 2.4e+02 0 0 1", "camera matrix", camera);
    expect_camera("# K\n[[700, 0, 320],\n [0, 700, 240],\n [0, 0, 1]]\n", "camera matrix", camera);
    expect_camera("700 0 0 0 700 0 320 240 1", "camera matrix", camera);  // by columns
    expect_camera("{\"K\": [[700, 0, 320], [0, 700, 240], [0, 0, 1]]}", "camera matrix", camera);
    expect_camera("{\"camera_matrix\": [700, 0, 320, 0, 700, 240, 0, 0, 1], \"width\": 640, \"height\": 480}",
                  "camera matrix", {700, 320.5, 240.5, 640, 480});
    expect_camera(
        "%YAML:1.0\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
        "   data: [ 700., 0., 320., 0., 700., 240., 0., 0., 1. ]\n",
        "camera matrix", camera);
}

TEST(ReadCameraMatrix, MayBeFollowedByTheBaseline) {
    expect_camera("754.668 0.0 489.379 0.0 754.668 265.161 0.0 0.0 1.0\n0.063\n",
                  "camera matrix and baseline", {754.668, 489.879, 265.661, 0, 0, 0.063});
}

TEST(ReadCameraMatrix, FocalLengthsThatNearlyAgreeBecomeTheirMean) {
    const CalibrationFile file = read("700 0 320\n0 702 240\n0 0 1\n");
    EXPECT_EQ(file.calibration.focal_px, 701);
    ASSERT_EQ(file.told.size(), 1u);
    EXPECT_CONTAINS(file.told[0], "702");
    EXPECT_TRUE(read("700 0 320\n0 700 240\n0 0 1\n").told.empty());
    EXPECT_CONTAINS(error_for("700 0 320\n0 720 240\n0 0 1\n"), "square");
}

std::string npy(const std::string& header, const std::string& data) {
    std::string text = std::string("\x93NUMPY\x01\0", 8);
    text += static_cast<char>(header.size());
    return text + '\0' + header + data;
}

TEST(ReadCameraMatrix, AsNumpySavesIt) {
    const std::string header = "{'descr': '<f8', 'fortran_order': False, 'shape': (3, 3), }\n";
    const double k[] = {700, 0, 320, 0, 700, 240, 0, 0, 1};
    const float by_columns[] = {700, 0, 0, 0, 700, 0, 320, 240, 1};
    const std::string data(reinterpret_cast<const char*>(k), sizeof k);
    expect_camera(npy(header, data), "camera matrix", {700, 320.5, 240.5});
    expect_camera(npy("{'descr': '<f4', 'fortran_order': True, 'shape': (3, 3), }\n",
                      std::string(reinterpret_cast<const char*>(by_columns), sizeof by_columns)),
                  "camera matrix", {700, 320.5, 240.5});
    EXPECT_CONTAINS(error_for(npy(header, data.substr(1))), "truncated");
    const std::string order = "'fortran_order': False, ";
    EXPECT_CONTAINS(error_for(npy("{'descr': '<u8', " + order + "'shape': (3, 3), }", data)),
                    "signed integers");
    EXPECT_CONTAINS(error_for(npy("{'descr': '<f8', " + order + "'shape': (4, 3), }", data)), "truncated");
    EXPECT_CONTAINS(error_for(npy("{'descr': '<f8', " + order + "'shape': (9999, 3), }", data)), "shape");
    expect_camera(npy("{'descr': '<f8', " + order + "'shape': (1, 9), }", data), "camera matrix",
                  {700, 320.5, 240.5});
    EXPECT_CONTAINS(error_for(npy(header, data).substr(0, 40)), "malformed NPY header");
    EXPECT_CONTAINS(error_for("\x93NUMPY"), "malformed NPY header");
}

TEST(ReadCameraMatrix, RefusesOthers) {
    EXPECT_CONTAINS(error_for("700 0 320 0 700 240 0 0"), "the file has 8 numbers");
    EXPECT_CONTAINS(error_for("1 2 3 4 5 6 7 8 9 10 11"), "11 numbers");
    EXPECT_CONTAINS(error_for("700 0 320 0 700 240 0 0 2"), "no camera matrix");
    EXPECT_CONTAINS(error_for("700 0 nan 0 700 240 0 0 1"), "number 3 is 'nan'");
    EXPECT_CONTAINS(error_for("700 0 320 0 7OO 240 0 0 1"), "number 5 is '7OO'");
    EXPECT_CONTAINS(error_for("700 12 320 0 700 240 0 0 1"), "skew");
    EXPECT_CONTAINS(error_for("-700 0 320 0 -700 240 0 0 1"), "focal length");
    EXPECT_CONTAINS(error_for("0 0 320 0 0 240 0 0 1"), "focal length");
    EXPECT_CONTAINS(error_for("700 0 320 0 700 240 0 0 1\n0\n"), "baseline");
    EXPECT_CONTAINS(error_for("700 0 320 0 700 240 0 0 1\n-0.1\n"), "baseline");
    EXPECT_CONTAINS(error_for("{\"K\": [700, 0, 320]}"), "K must hold the 9 numbers");
    EXPECT_CONTAINS(error_for("{\"K\": [[700, 0], [320, 1], [2, 3]]}"), "K must hold the 9 numbers");
    EXPECT_CONTAINS(error_for("{\"K\": \"none\"}"), "9 numbers of K");
    EXPECT_CONTAINS(error_for("{\"K\": [[700, 0, 320], [0, true, 240], [0, 0, 1]]}"), "K is 'true'");
    EXPECT_CONTAINS(error_for("{\"K\": [700, 0, 320, 0, 700, 240, 0, 0, 1"), "line");
}

TEST(ReadOpen3dCamera, HasItsMatrixByColumns) {
    const std::string intrinsic =
        "{\n\t\"height\" : 480,\n\t\"intrinsic_matrix\" : \n\t[\n\t\t525.0,\n\t\t0.0,\n\t\t0.0,\n\t\t0.0,\n"
        "\t\t525.0,\n\t\t0.0,\n\t\t319.5,\n\t\t239.5,\n\t\t1.0\n\t],\n\t\"width\" : 640\n}";
    expect_camera(intrinsic, "Open3D intrinsics", {525, 320, 240, 640, 480});
    expect_camera("{\"class_name\" : \"PinholeCameraParameters\", \"extrinsic\": [1, 0], \"intrinsic\": " +
                      intrinsic + "}",
                  "Open3D intrinsics", {525, 320, 240, 640, 480});
    EXPECT_CONTAINS(error_for("{\"intrinsic_matrix\": [525, 0, 0], \"width\": 640, \"height\": 480}"),
                    "intrinsic_matrix has 3 numbers");
    EXPECT_CONTAINS(
        error_for("{\"intrinsic_matrix\": [5, 0, 0, 0, 5, 0, 3, 2, 1], \"width\": 0, \"height\": 480}"),
        "width");
}

TEST(ReadRealSenseCamera, HasPrincipalPointsOfItsOwnName) {
    const std::string text =
        "{\"fx\": 615.0, \"fy\": 615.5, \"ppx\": 319.5, \"ppy\": 239.5, \"width\": 640, \"height\": 480, "
        "\"model\": \"distortion.inverse_brown_conrady\", \"coeffs\": [0.0, 0.0, 0.0, 0.0, 0.0]}";
    expect_camera(text, "RealSense intrinsics", {615.25, 320, 240, 640, 480});
    EXPECT_EQ(read(text).told.size(), 1u);
    expect_camera("fx: 615\nfy: 615\ncx: 319.5\ncy: 239.5\n", "intrinsics", {615, 320, 240});
    const CalibrationFile distorted = read("{fx: 6, fy: 6, cx: 3, cy: 2, coeffs: [0.1, 0, 0, 0, 0]}");
    ASSERT_EQ(distorted.told.size(), 1u);
    EXPECT_CONTAINS(distorted.told[0], "distorts");
    EXPECT_CONTAINS(error_for("{\"fx\": 615, \"ppx\": 319, \"ppy\": 239}"), "fy is missing");
    EXPECT_CONTAINS(error_for("{\"fx\": 615, \"fy\": 615, \"ppy\": 239}"), "ppx is missing");
    EXPECT_CONTAINS(error_for("{\"fx\": true, \"fy\": 615, \"ppx\": 3, \"ppy\": 2}"), "fx is 'true'");
    EXPECT_CONTAINS(error_for("{\"fx\": 615, \"fy\": 615, \"ppx\": 3, \"ppy\": 2, \"coeffs\": [a, 0, 0, 0]}"),
                    "coeffs");
}

const std::string kRosFile =
    "image_width: 640\nimage_height: 480\ncamera_name: left\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
    "  data: [430.1, 0, 306.6, 0, 430.5, 227.4, 0, 0, 1]\ndistortion_model: plumb_bob\n"
    "distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [-0.3, 0.1, 0, 0, 0]\n"
    "rectification_matrix:\n  rows: 3\n  cols: 3\n  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n"
    "projection_matrix:\n  rows: 3\n  cols: 4\n  data: [400, 0, 310, 0, 0, 400, 230, 0, 0, 0, 1, 0]\n";

TEST(ReadRosCamera, TheProjectionOfTheRectifiedPicture) {
    expect_camera(kRosFile, "ROS camera_info", {400, 310.5, 230.5, 640, 480});
    EXPECT_TRUE(read(kRosFile).told.empty());
    const std::string right = replaced(kRosFile, "310, 0, 0, 400", "310, -48, 0, 400");
    expect_camera(right, "ROS camera_info", {400, 310.5, 230.5, 640, 480, 0.12});
    EXPECT_CONTAINS(read(right).told.at(0), "right camera");
    expect_camera(
        "header:\n  seq: 3\n  frame_id: \"left\"\nheight: 480\nwidth: 640\ndistortion_model: \"plumb_bob\"\n"
        "D: [0.0, 0.0, 0.0, 0.0, 0.0]\nK: [430.0, 0.0, 306.0, 0.0, 430.0, 227.0, 0.0, 0.0, 1.0]\n"
        "R: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]\n"
        "P: [400.0, 0.0, 310.0, 0.0, 0.0, 400.0, 230.0, 0.0, 0.0, 0.0, 1.0, 0.0]\nbinning_x: 0\n---\n",
        "ROS camera_info", {400, 310.5, 230.5, 640, 480});
}

TEST(ReadRosCamera, WithoutAProjectionTheCameraItself) {
    const std::string plain = replaced(kRosFile, "[400, 0, 310, 0, 0, 400, 230,", "[0, 0, 0, 0, 0, 0, 0,");
    const CalibrationFile file = read(plain);
    EXPECT_NEAR(file.calibration.focal_px, 430.3, 1e-9);
    EXPECT_NEAR(file.calibration.cx, 307.1, 1e-9);
    EXPECT_EQ(file.told.size(), 2u);  // distortion, and two different focal lengths
}

TEST(ReadRosCamera, NamesTheKeyThatIsWrong) {
    EXPECT_CONTAINS(error_for(replaced(kRosFile, "[400, 0, 310, 0,", "[400, 0, 310,")), "projection_matrix");
    EXPECT_CONTAINS(error_for(replaced(kRosFile, "[400, 0, 310,", "[400, 0, .nan,")), "projection_matrix is");
    EXPECT_CONTAINS(error_for(replaced(kRosFile, "400, 230, 0", "400, 230, -48")), "vertical");
    EXPECT_CONTAINS(error_for(replaced(kRosFile, "310, 0, 0, 400", "310, 48, 0, 400")), "baseline");
    EXPECT_CONTAINS(error_for(replaced(kRosFile, "image_width: 640", "image_width: 6.5")), "image_width");
}

TEST(ReadColmapCamera, CountsPixelCentresAsCalibrationDoes) {
    expect_camera("# Camera list with one line of data per camera:\n1 PINHOLE 640 480 500 502 320 240\n",
                  "COLMAP", {501, 320, 240, 640, 480});
    expect_camera("3 SIMPLE_PINHOLE 640 480 500 320 240\r\n", "COLMAP", {500, 320, 240, 640, 480});
}

TEST(ReadColmapCamera, RefusesOthers) {
    EXPECT_CONTAINS(error_for("1 SIMPLE_RADIAL 640 480 500 320 240 0.1\n"), "undistort");
    EXPECT_CONTAINS(error_for("1 OPENCV 640 480 500 500 320 240 0 0 0 0.1\n"), "camera 1");
    EXPECT_CONTAINS(error_for("1 PINHOLE 640 480 500 320 240\n"), "has 7 entries; PINHOLE has 8");
    EXPECT_CONTAINS(error_for("1 PINHOLE 640 480 500 x 320 240\n"), "camera 1 is 'x'");
    EXPECT_CONTAINS(error_for("1 PINHOLE 0 480 500 500 320 240\n"), "camera 1's width");
    EXPECT_CONTAINS(error_for("1 PINHOLE 640 480 5 5 3 2\n2 PINHOLE 640 480 6 6 3 2\n"), "2 cameras");
}

}  // namespace
}  // namespace hexrelief::readers
