#include "pipeline/readers/cameras/calibration_reader.h"

#include <cmath>

#include "tests/pipeline/readers/sample_files.h"

namespace hexrelief::readers {
namespace {

Calibration read(std::string_view text) {
    const Folder folder;
    return read_calibration_file(folder.write("calibration", text)).calibration;
}

std::string error_for(std::string_view text) {
    return error_of_file("bad.txt", text, [](const auto& path) { read_calibration_file(path); });
}

void expect_calibration(const Calibration& c, double focal, double cx, double cy, double baseline,
                        double doffs, int width, int height) {
    EXPECT_NEAR(c.focal_px, focal, 1e-9);
    EXPECT_NEAR(c.cx, cx, 1e-9);
    EXPECT_NEAR(c.cy, cy, 1e-9);
    EXPECT_NEAR(c.baseline_m, baseline, 1e-9);
    EXPECT_NEAR(c.doffs_px, doffs, 1e-9);
    EXPECT_EQ(c.width, width);
    EXPECT_EQ(c.height, height);
    EXPECT_EQ(c.metric, baseline > 0);
}

const std::string kMiddlebury =
    "cam0=[ 713.189 0 356.021 ; 0 713.189 238.263 ; 0 0 1 ] \n"
    "cam1=[ 713.189 0 387.361 ; 0 713.189 238.263 ; 0 0 1 ] \n"
    "doffs= 31.34\n baseline= 178.089 \nwidth= 707\n height= 481 \n ndisp= 65\n isint= 0 \nvmin= 9 \n";

TEST(ReadMiddleburyCalibration, AsPublished) {
    expect_calibration(read(kMiddlebury), 713.189, 356.521, 238.763, 0.178089, 31.34, 707, 481);
    EXPECT_EQ(read(kMiddlebury).ndisp_px, 65);
    EXPECT_EQ(read(replaced(kMiddlebury, "ndisp= 65\n", "")).ndisp_px, 0);
}

TEST(ReadMiddleburyCalibration, AsPeopleWriteIt) {
    const Calibration c = read(
        "\xef\xbb\xbf# my camera\r\n\r\n  cam0 = [1000,0,320; 0,1000,240;0 0 1]\t\r\n\tbaseline =\t+1.2e2  # "
        "mm\r\n"
        "doffs=-3\r\nnotes = two = signs\r\n\r\n   ");
    expect_calibration(c, 1000, 320.5, 240.5, 0.12, -3, 0, 0);
    EXPECT_NEAR(read(replaced(kMiddlebury, "doffs= 31.34\n", "")).doffs_px, 31.34, 1e-9);  // from cam1
    std::string old_ends = kMiddlebury;
    for (char& ch : old_ends) ch = ch == '\n' ? '\r' : ch;
    EXPECT_EQ(read(old_ends).width, 707);
}

TEST(ReadMiddleburyCalibration, NamesTheKeyThatIsWrong) {
    const auto with = [](const char* from, const char* to) {
        return error_for(replaced(kMiddlebury, from, to));
    };
    EXPECT_CONTAINS(with(" baseline= 178.089 \n", ""), "baseline is missing");
    EXPECT_CONTAINS(with("cam0", "camx"), "cam0 is missing");
    EXPECT_CONTAINS(with("178.089", "wide"), "baseline is 'wide'");
    EXPECT_CONTAINS(with("178.089", "nan"), "baseline is 'nan'");
    EXPECT_CONTAINS(with("178.089", ""), "baseline is ''");
    EXPECT_CONTAINS(with("178.089", "0"), "baseline");
    EXPECT_CONTAINS(with("178.089", "-178.089"), "baseline");
    EXPECT_CONTAINS(with("178.089", "1e999"), "baseline");
    EXPECT_CONTAINS(with("31.34", "31,34"), "doffs is '31,34'");
    EXPECT_CONTAINS(with("707", "707.5"), "width");
    EXPECT_CONTAINS(with("707", "0"), "width");
    EXPECT_CONTAINS(with("65", "-1"), "ndisp");
    EXPECT_CONTAINS(with("481", "99999999999"), "height");
    EXPECT_CONTAINS(with("713.189 0 356.021", "713.189 356.021"), "cam0 has 8");
    EXPECT_CONTAINS(with("0 713.189 238.263", "0 613.189 238.263"), "square");
    EXPECT_CONTAINS(with("0 0 1", "0 0 2"), "camera matrix");
    EXPECT_CONTAINS(error_for(kMiddlebury + "width=1\n"), "'width' is given twice");
    EXPECT_CONTAINS(error_for(kMiddlebury + "and some words\n"), "'and some words'");
    EXPECT_CONTAINS(error_for("cam0=[-700 0 3; 0 -700 4; 0 0 1]\nbaseline=1\ndoffs=0\n"), "focal length");
    EXPECT_CONTAINS(error_for("cam0=[700 0 3; 0 700 4; 0 0 1]\nbaseline=1\n"), "doffs is missing");
}

const std::string kKitti =
    "P0: 7.0e+02 0.0 6.0e+02 0.0 0.0 7.0e+02 1.8e+02 0.0 0.0 0.0 1.0 0.0\n"
    "P1: 7.0e+02 0.0 6.0e+02 -3.5e+02 0.0 7.0e+02 1.8e+02 0.0 0.0 0.0 1.0 0.0\n"
    "P2: 7.0e+02 0.0 6.1e+02 4.2e+01 0.0 7.0e+02 1.7e+02 2.1e-01 0.0 0.0 1.0 2.7e-03\n"
    "P3: 7.0e+02 0.0 6.1e+02 -3.36e+02 0.0 7.0e+02 1.7e+02 2.1e+00 0.0 0.0 1.0 2.7e-03\n"
    "R0_rect: 9.9e-01 0 0 0 1 0 0 0 1\nTr_velo_to_cam: 1 2 3 4 5 6 7 8 9 10 11 12\n";

TEST(ReadKittiCalibration, PrefersTheColourPair) {
    expect_calibration(read(kKitti), 700, 610.5, 170.5, 0.54, 0, 0, 0);
    expect_calibration(read(kKitti.substr(0, kKitti.find("P2:"))), 700, 600.5, 180.5, 0.5, 0, 0, 0);
}

TEST(ReadKittiCalibration, RawFilesHaveASize) {
    const Calibration c = read(
        "calib_time: 09-Jan-2012 13:57:47\ncorner_dist: 9.95e-02\nS_02: 1392 512\nK_02: 9 0 6 0 9 2 0 0 1\n"
        "S_rect_02: 1.242e+03 3.75e+02\n"
        "P_rect_02: 700 0 610 42 0 700 170 0 0 0 1 0\r\nP_rect_03: 700 0 612 -336 0 700 170 0 0 0 1 0\r\n");
    expect_calibration(c, 700, 610.5, 170.5, 0.54, 2, 1242, 375);
}

TEST(ReadKittiCalibration, OneProjectionIsOneView) {
    expect_calibration(read("P_rect_02: 700 0 610 42 0 700 170 0 0 0 1 0\nS_rect_02: 1242 375\n"), 700, 610.5,
                       170.5, 0, 0, 1242, 375);
}

TEST(ReadKittiCalibration, NamesTheKeyThatIsWrong) {
    EXPECT_CONTAINS(error_for(replaced(kKitti, "-3.36e+02", "")), "P3 has 11");
    EXPECT_CONTAINS(error_for(replaced(kKitti, "-3.36e+02", "nan")), "P3 is 'nan'");
    EXPECT_CONTAINS(error_for(replaced(kKitti, "-3.36e+02", "3.36e+02")), "baseline");
    EXPECT_CONTAINS(error_for(replaced(kKitti, "P2: 7.0e+02", "P2: 0")), "P2");
    EXPECT_CONTAINS(error_for("P1: 7 0 6 4 0 7 1 0 0 0 1 0\nP2: 7 0 6 4 0 7 1 0 0 0 1 0\n"), "P1 and P2");
    EXPECT_CONTAINS(error_for(kKitti + "P2: 1 2 3\n"), "P2 is given twice");
}

const std::string kQ =
    "%YAML:1.0\n---\nR: !!opencv-matrix\n   rows: 3\n   cols: 1\n   dt: d\n   data: [ 1., 2., .Nan ]\n"
    "Q: !!opencv-matrix\n   rows: 4\n   cols: 4\n   dt: d\n"
    "   data: [ 1., 0., 0., -3.2000000000000000e+02, 0., 1., 0.,\n       -240., 0., 0., 0., 500., 0., 0.,\n"
    "       8., -40. ]\n";

const std::string kProjections =
    "%YAML:1.0\nimage_width: 640\nimage_height: 480\n"
    "P1: !!opencv-matrix\n   rows: 3\n   cols: 4\n   dt: d\n"
    "   data: [ 500., 0., 320., 0., 0., 500., 240., 0., 0., 0., 1., 0. ]\n"
    "P2: !!opencv-matrix\n   rows: 3\n   cols: 4\n   dt: d\n"
    "   data: [ 500., 0., 315., -62.5, 0., 500., 240., 0., 0., 0., 1., 0. ]\n";

TEST(ReadOpenCvCalibration, QAndProjectionsAgree) {
    expect_calibration(read(kQ), 500, 320.5, 240.5, 0.125, -5, 0, 0);
    expect_calibration(read(kProjections), 500, 320.5, 240.5, 0.125, -5, 640, 480);
    const std::string sized = replaced(kQ, "---\n", "---\nimage_size: [ 640, 480 ]\n");
    EXPECT_EQ(read(sized).width, 640);
    EXPECT_EQ(read(sized).height, 480);
}

TEST(ReadOpenCvCalibration, NamesTheKeyThatIsWrong) {
    EXPECT_CONTAINS(error_for(replaced(kQ, "8., -40.", "8.")), "Q must hold rows times cols numbers");
    EXPECT_CONTAINS(error_for(replaced(kQ, "8., -40.", "0., -40.")), "baseline");
    EXPECT_CONTAINS(error_for(replaced(kQ, "8., -40.", "-8., -40.")), "baseline");
    EXPECT_CONTAINS(error_for(replaced(kQ, "8., -40.", ".Nan, -40.")), "Q is '.Nan'");
    EXPECT_CONTAINS(error_for(replaced(kQ, "rows: 4", "rows: 3")), "Q");
    EXPECT_CONTAINS(
        error_for(replaced(kProjections, "-62.5, 0., 500., 240., 0.", "0., 0., 500., 240., -62.5")),
        "vertical");
    EXPECT_CONTAINS(error_for("%YAML:1.0\nM1: 3\n"), "Q, or P1 and P2");
    EXPECT_CONTAINS(error_for("%YAML:1.0\nQ: [1, 2\nx: }"), "line");
    EXPECT_CONTAINS(error_for("<?xml version=\"1.0\"?>\n<opencv_storage/>\n"), "Q, or P1 and P2");
}

const std::string kKeys = "focal_px: 3740  # Aloe\nbaseline_m: 0.160\ncx: 641\ncy: 555\ndoffs_px: 270\n";

TEST(ReadOwnCalibration, CountsPixelCentresAsCalibrationDoes) {
    expect_calibration(read(kKeys), 3740, 641, 555, 0.16, 270, 0, 0);
    expect_calibration(read("{focal_px: 10, baseline_m: 1, width: 7, height: 4}"), 10, 3.5, 2, 1, 0, 7, 4);
}

TEST(ReadOwnCalibration, FocalLengthAlone) {
    const Calibration c = read("focal_px: 700\n");
    EXPECT_EQ(c.focal_px, 700);
    EXPECT_EQ(c.baseline_m, 0);
    EXPECT_TRUE(std::isnan(c.cx) && std::isnan(c.cy));
    EXPECT_FALSE(c.metric);
    expect_calibration(read("focal_px: 700\nwidth: 8\nheight: 6\n"), 700, 4, 3, 0, 0, 8, 6);
}

TEST(ReadOwnCalibration, NamesTheKeyThatIsWrong) {
    EXPECT_CONTAINS(error_for(replaced(kKeys, "baseline_m", "baseline")), "'baseline' is not known");
    EXPECT_CONTAINS(error_for("baseline_m: 0.16\n"), "focal_px is missing");
    EXPECT_CONTAINS(error_for(replaced(kKeys, "0.160", "0")), "baseline");
    EXPECT_CONTAINS(error_for(replaced(kKeys, "cx: 641\n", "")), "cx and cy");
    EXPECT_CONTAINS(error_for(replaced(kKeys, "3740", "[3740, 3740]")), "focal_px must be a number");
    EXPECT_CONTAINS(error_for(replaced(kKeys, "3740", "-1")), "focal length");
    EXPECT_CONTAINS(error_for(kKeys + "cx: 3\n"), "'cx' is given twice");
    EXPECT_CONTAINS(error_for(kKeys + "width: 3\n"), "together");
}

TEST(ReadCalibration, RefusesWhatIsNoCalibration) {
    EXPECT_CONTAINS(error_for(""), "empty");
    EXPECT_CONTAINS(error_for("  \n \n"), "empty");
    EXPECT_CONTAINS(error_for("hello\n"), "not a calibration");
    EXPECT_CONTAINS(error_for("a: b\n"), "not a calibration");
    EXPECT_CONTAINS(error_for(std::string_view("cam0=\0\1", 7)), "binary");
    EXPECT_CONTAINS(error_for(std::string(5000, '[')), "bad.txt");
    EXPECT_CONTAINS(error_for(std::string(2u << 20, 'x')), "bytes");
    const Folder folder;
    EXPECT_CONTAINS(error_of([&] { read_calibration_file(folder.path() / "none"); }), "no such file");
    EXPECT_CONTAINS(error_of([&] { read_calibration_file(folder.path()); }), "folder");
}

}  // namespace
}  // namespace hexrelief::readers
