// Tests the formats of one view, and that documents and messages list all formats.
#include <bit>
#include <cmath>
#include <fstream>
#include <sstream>

#include "pipeline/readers/cameras/calibration_reader.h"
#include "pipeline/readers/cameras/key_table.h"
#include "tests/pipeline/readers/sample_files.h"

namespace hexrelief::readers {
namespace {

CalibrationFile read(const Bytes& bytes, int width = 0, int height = 0) {
    const Folder folder;
    return read_calibration_file({folder.write("view", bytes), {}, width, height});
}

CalibrationFile read(const std::string& text, int width = 0, int height = 0) {
    return read(to_bytes(text), width, height);
}

std::string error_for(const std::string& text) {
    return error_of([&] { read(text); });
}

void expect_view(const CalibrationFile& file, const std::string& format, double focal, double cx, double cy,
                 int width = 0, int height = 0) {
    const Calibration& c = file.calibration;
    EXPECT_EQ(file.format, format);
    EXPECT_NEAR(c.focal_px, focal, 1e-9) << format;
    EXPECT_NEAR(c.cx, cx, 1e-9) << format;
    EXPECT_NEAR(c.cy, cy, 1e-9) << format;
    EXPECT_EQ(c.width, width) << format;
    EXPECT_EQ(c.height, height) << format;
    EXPECT_EQ(c.baseline_m, 0) << format;
    EXPECT_FALSE(c.metric);
}

TEST(ReadViewFormats, NumbersAlone) {
    expect_view(read("700 0 320 0\n0 700 240 0\n0 0 1 0\n0 0 0 1\n"), "camera matrix", 700, 320.5, 240.5);
    expect_view(read("700 0 320 0\n0 700 240 0\n0 0 1 0\n"), "camera matrix", 700, 320.5, 240.5);
    expect_view(read("700 700 320 240\n"), "numbers alone", 700, 320.5, 240.5);
    expect_view(read("640 480 700 700 320 240"), "numbers alone", 700, 320.5, 240.5, 640, 480);
    EXPECT_CONTAINS(error_for("640.5 480 700 700 320 240"), "the width");
    EXPECT_CONTAINS(error_for("0 0 320 240"), "focal length");
    EXPECT_CONTAINS(error_for("700 700 nan 240"), "'nan'");
    EXPECT_CONTAINS(error_for("700 700 320 240 1"), "5 numbers");
}

TEST(ReadViewFormats, Mvsnet) {
    const std::string text =
        "extrinsic\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n\nintrinsic\n700 0 320\n0 700 240\n0 0 1\n";
    expect_view(read(text + "\n425.0 2.5 192 935\n"), "MVSNet", 700, 320.5, 240.5);
    EXPECT_CONTAINS(error_for(text.substr(0, text.size() - 8)), "9 numbers of K");
}

TEST(ReadViewFormats, NerfTransforms) {
    const char* const format = "nerfstudio and instant-ngp";
    expect_view(
        read("{\"fl_x\": 700, \"fl_y\": 700, \"cx\": 320, \"cy\": 240, \"w\": 640, \"h\": 480, \"frames\": "
             "[{\"file_path\": \"a.png\", \"transform_matrix\": [[1, 0], [0, 1]]}]}"),
        format, 700, 320, 240, 640, 480);
    const CalibrationFile bent =
        read("{\"fl_x\": 700, \"cx\": 320, \"cy\": 240, \"k1\": 0.1, \"k2\": 0, \"p1\": 0, \"p2\": 0}");
    EXPECT_CONTAINS(bent.told.at(0), "distorts");
    const double angle = 2 * std::atan(320.0 / 700);
    std::ostringstream text;
    text.precision(15);
    text << "{\"camera_angle_x\": " << angle << ", \"frames\": []}";
    EXPECT_NEAR(read(text.str(), 640, 480).calibration.focal_px, 700, 1e-9);
    EXPECT_TRUE(std::isnan(read(text.str(), 640, 480).calibration.cx));
    EXPECT_CONTAINS(error_for(text.str()), "size of a picture");
    const auto frames = [](const char* second) {
        return std::string("{\"frames\": [{\"fl_x\": 700, \"cx\": 3, \"cy\": 2}, {\"fl_x\": ") + second +
               ", \"cx\": 3, \"cy\": 2}]}";
    };
    EXPECT_EQ(read(frames("700")).calibration.focal_px, 700);
    EXPECT_CONTAINS(error_for(frames("701")), "frames.1.fl_x differ");
}

TEST(ReadViewFormats, TheUnitOfDepths) {
    const auto per_m = [](const std::string& key, const char* value) {
        return read("{\"fx\": 700, \"fy\": 700, \"cx\": 320, \"cy\": 240, \"" + key + "\": " + value + "}")
            .depth_per_m;
    };
    EXPECT_EQ(read("700 700 320 240\n").depth_per_m, 0);
    EXPECT_NEAR(per_m("depth_scale", "0.1"), 10000, 1e-9) << "BOP, mm";
    EXPECT_NEAR(per_m("depth_scale", "1.0"), 1000, 1e-9);
    EXPECT_NEAR(per_m("depth_scale", "0.00025"), 4000, 1e-9) << "RealSense, m";
    EXPECT_NEAR(per_m("depth_scale", "1000"), 1000, 1e-9) << "Open3D";
    EXPECT_EQ(per_m("png_depth_scale", "6553.5"), 6553.5);
    EXPECT_EQ(read("Camera.fx: 517\nCamera.fy: 516\nCamera.cx: 318\nCamera.cy: 255\nDepthMapFactor: 5000.0\n")
                  .depth_per_m,
              5000);
    EXPECT_CONTAINS(error_of([&] { per_m("depth_scale", "0"); }), "depth_scale is 0; it must be above 0");
    EXPECT_CONTAINS(error_of([&] { per_m("depth_scale", ".nan"); }), "finite");
}

TEST(ReadViewFormats, AListOfViewsHasThatOfThePicture) {
    const Folder folder;
    const auto focal = [&](const std::string& text, const char* view) {
        return read_calibration_file({folder.write("views.json", to_bytes(text)), {}, 640, 480, {view}})
            .calibration.focal_px;
    };
    const auto bop = [](const char* number, const char* length) {
        return std::string("\"") + number + "\": {\"cam_K\": [" + length + ", 0, 320, 0, " + length +
               ", 240, 0, 0, 1], \"depth_scale\": 0.1}";
    };
    const std::string images = "{" + bop("0", "500") + ", " + bop("7", "700") + ", " + bop("70", "900") + "}";
    EXPECT_EQ(focal(images, "depth/000007.png"), 700);
    EXPECT_EQ(focal(images, "rgb/000000.jpg"), 500);
    EXPECT_EQ(focal(images, "000070_000001.png"), 900);
    EXPECT_CONTAINS(error_of([&] { focal(images, "rgb/left.png"); }),
                    "differ; keep the picture's own camera");
    EXPECT_CONTAINS(error_of([&] { focal(images, "rgb/000008.png"); }), "differ");
    const std::string frames =
        "{\"fl_x\": 300, \"cx\": 320, \"cy\": 240, \"frames\": [{\"file_path\": \"images/a.jpg\", \"fl_x\": "
        "400}, {\"file_path\": \"images/b.jpg\", \"fl_x\": 600}, {\"file_path\": \"images/c.jpg\"}]}";
    EXPECT_EQ(focal(frames, "images/b.jpg"), 600);
    EXPECT_EQ(focal(frames, "depth/a.png"), 400);
    EXPECT_EQ(focal(frames, "images/c.jpg"), 300);
}

TEST(ReadViewFormats, DataSets) {
    expect_view(read("{\"0\": {\"cam_K\": [700, 0, 320, 0, 700, 240, 0, 0, 1], \"depth_scale\": 0.1}, \"7\": "
                     "{\"cam_K\": [700, 0, 320, 0, 700, 240, 0, 0, 1], \"depth_scale\": 0.1}}"),
                "BOP", 700, 320.5, 240.5);
    EXPECT_CONTAINS(
        error_for("{\"0\": {\"cam_K\": [7, 0, 3, 0, 7, 2, 0, 0, 1]}, \"1\": {\"cam_K\": [8, 0, 3, 0, 8, 2, "
                  "0, 0, 1]}}"),
        "1.cam_K differ");
    const CalibrationFile moge = read("{\"fov_x\": 90, \"fov_y\": 73.7}", 640, 480);
    EXPECT_EQ(moge.format, "MoGe");
    EXPECT_NEAR(moge.calibration.focal_px, 320, 1e-9);
    EXPECT_TRUE(std::isnan(moge.calibration.cx));
    EXPECT_CONTAINS(error_of([] { read("{\"fov_x\": 180}", 640, 480); }), "180 degrees");
    const CalibrationFile city = read(
        "{\"extrinsic\": {\"baseline\": 0.2, \"pitch\": 0.03, \"roll\": 0, \"x\": 1.7, \"y\": 0, \"yaw\": 0, "
        "\"z\": 1}, "
        "\"intrinsic\": {\"fx\": 2262, \"fy\": 2262, \"u0\": 1096, \"v0\": 513}}");
    EXPECT_EQ(city.format, "Cityscapes");
    EXPECT_NEAR(city.calibration.baseline_m, 0.2, 1e-12);
    EXPECT_NEAR(city.calibration.cx, 1096.5, 1e-12);
    EXPECT_TRUE(city.calibration.metric);
}

TEST(ReadViewFormats, Apps) {
    expect_view(
        read("colorHeight = 968\ncolorWidth = 1296\ndepthHeight = 480\ndepthShift = 1000\ndepthWidth = 640\n"
             "fx_color = 1170\nfx_depth = 577\nfy_color = 1170\nfy_depth = 577\nmx_color = 647\nmx_depth = "
             "319.5\nmy_color = 483\nmy_depth = 239.5\nsceneType = Apartment\n"),
        "ScanNet", 577, 320, 240, 640, 480);
    const CalibrationFile replica = read(
        "{\"camera\": {\"w\": 640, \"h\": 480, \"fx\": 600, \"fy\": 600, \"cx\": 319.5, \"cy\": 239.5, "
        "\"scale\": "
        "6553.5}}");
    EXPECT_EQ(replica.depth_per_m, 6553.5);
    std::string sixteen = "1";
    for (int i = 0; i < 15; ++i) sixteen += ", 0";
    expect_view(read("{\"intrinsics\": [700, 0, 320, 0, 700, 240, 0, 0, 1], \"projectionMatrix\": [" +
                     sixteen + "]}"),
                "camera matrix", 700, 320.5, 240.5);
}

// MATLAB shows matrices turned, below their names, and large ones with a factor.
TEST(ReadViewFormats, MatlabAsItIsShown) {
    const CalibrationFile file = read(
        "IntrinsicMatrix =\n\n   1.0e+03 *\n\n    0.7000 0 0\n    0 0.7000 0\n    0.3210 0.2410 0.0010\n\n"
        "RadialDistortion =\n\n    0    0\n\nImageSize =\n\n    480    640\n");
    expect_view(file, "MATLAB", 700, 320.5, 240.5, 640, 480);
    EXPECT_CONTAINS(error_for("IntrinsicMatrix =\n\n 1.0e+03 *\n\n 0.7 0 0\nRadialDistortion = [0 0]\n"),
                    "3 numbers");
}

TEST(ReadViewFormats, ModelsWithMoreNumbersAreNamed) {
    EXPECT_CONTAINS(error_for("cam0:\n  camera_model: omni\n  intrinsics: [1.2, 320, 320, 159.5, 119.5]\n"),
                    "'omni'");
}

TEST(ReadViewFormats, ColmapCamerasWithoutALens) {
    expect_view(read("1 OPENCV 640 480 700 700 320 240 0 0 0 0\n"), "COLMAP", 700, 320, 240, 640, 480);
    expect_view(read("1 SIMPLE_RADIAL 640 480 700 320 240 0\n2 SIMPLE_RADIAL 640 480 700 320 240 0\n"),
                "COLMAP", 700, 320, 240, 640, 480);
    EXPECT_CONTAINS(error_for("1 OPENCV 640 480 700 700 320 240 0 0 0 0.1\n"), "OPENCV");
    EXPECT_CONTAINS(error_for("1 OPENCV_FISHEYE 640 480 700 700 320 240 0 0 0 0\n"), "OPENCV_FISHEYE");
    EXPECT_CONTAINS(error_for("1 OPENCV 640 480 700 700 320 240 0 0\n"), "10 entries; OPENCV has 12");
    EXPECT_CONTAINS(error_for("1 PINHOLE 640 480 700 700 320 240\n2 PINHOLE 640 480 700 700 320 241\n"),
                    "2 cameras");
    EXPECT_CONTAINS(error_for("1 PINHOLE 640 480 700 700 320 240\n2 PINHOLE 640\n"), "2 cameras");
}

TEST(ReadViewFormats, DrivingStereo) {
    const CalibrationFile file = read(
        "calib_time: 2018-07-09\nS_101: 1920 1080\nS_rect_101: 1758 1114\nP_rect_101: 2000 0 900 0 0 2000 "
        "550 0 0 0 1 0\n"
        "P_rect_103: 2000 0 900 -1080 0 2000 550 0 0 0 1 0\n");
    EXPECT_EQ(file.format, "KITTI");
    EXPECT_NEAR(file.calibration.baseline_m, 0.54, 1e-9);
    EXPECT_EQ(file.calibration.width, 1758);
}

void put(Bytes& bytes, std::uint64_t value, int size) {
    for (int i = 0; i < size; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

TEST(ReadViewFormats, ColmapBinary) {
    const auto cameras = [](std::uint64_t count, std::uint32_t model, const std::vector<double>& parameters) {
        Bytes bytes;
        put(bytes, count, 8);
        put(bytes, 1, 4);
        put(bytes, model, 4);
        put(bytes, 640, 8);
        put(bytes, 480, 8);
        for (const double number : parameters) put(bytes, std::bit_cast<std::uint64_t>(number), 8);
        return bytes;
    };
    expect_view(read(cameras(1, 1, {700, 700, 320, 240})), "COLMAP", 700, 320, 240, 640, 480);
    expect_view(read(cameras(1, 0, {700, 320, 240})), "COLMAP", 700, 320, 240, 640, 480);
    EXPECT_CONTAINS(error_of([&] { read(cameras(1, 2, {700, 320, 240, 0.1})); }), "SIMPLE_RADIAL");
    EXPECT_CONTAINS(error_of([&] { read(cameras(1, 1, {700, 320, 240})); }), "binary");
    EXPECT_CONTAINS(error_of([&] { read(cameras(1, 99, {700, 320, 240})); }), "binary");
    EXPECT_CONTAINS(error_of([&] { read(cameras(~0ull, 1, {700, 700, 320, 240})); }), "binary");
    EXPECT_CONTAINS(error_of([&] { read(cameras(1, 1, {std::nan(""), 700, 320, 240})); }), "'nan'");
}

TEST(ReadViewFormats, AliasesDoNotGrow) {
    std::string text = "a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1]\n";
    for (int i = 1; i < 12; ++i) {
        const std::string before = "*a" + std::to_string(i - 1);
        text += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " {";
        for (int k = 0; k < 8; ++k) text += (k > 0 ? ", k" : "k") + std::to_string(k) + ": " + before;
        text += "}\n";
    }
    EXPECT_CONTAINS(error_for(text), "too many values");
}

TEST(ReadViewFormats, DocumentsAndMessagesListAll) {
    std::string rows;
    for (const codec::Family& family : codec::families())
        rows += "| " + std::string(family.name) + " | " + family.holds + " | " + family.gives + " |\n";
    std::ifstream file(HEXRELIEF_SOURCE_DIR "/exporters/FORMATS.md");
    std::stringstream page;
    page << file.rdbuf();
    EXPECT_CONTAINS(page.str(), "| --- | --- | --- |\n" + rows + "\n") << "write FORMATS.md anew as this:\n"
                                                                       << rows;
    const std::string message = error_for("a: b\n");
    for (const codec::Family& family : codec::families()) EXPECT_CONTAINS(message, family.name);
}

}  // namespace
}  // namespace hexrelief::readers
