// Tests that each format of two cameras gives the same pair, written as its program writes it.
#include <cmath>
#include <sstream>

#include "pipeline/readers/cameras/calibration_reader.h"
#include "tests/pipeline/readers/depth/sample_maps.h"
#include "tests/pipeline/readers/sample_files.h"

namespace hexrelief::readers {
namespace {

using Numbers = std::vector<double>;

const Numbers kLeft = {500, 0, 320, 0, 500, 240, 0, 0, 1}, kRight = {510, 0, 318, 0, 510, 242, 0, 0, 1},
              kLeftLens = {-0.1, 0.02, 0.001, -0.002, 0.003}, kRightLens = {-0.2, 0.03, 0, 0.001, 0};
// A turn by asin(0.6) about the y axis, and 12 cm.
const Numbers kTurn = {0.8, 0, 0.6, 0, 1, 0, -0.6, 0, 0.8}, kMove = {-0.12, 0.002, 0.003};

std::string text_of(double number) {
    std::ostringstream text;
    text.precision(15);
    text << number;
    return text.str();
}

std::string joined(const Numbers& numbers, const std::string& between = ", ") {
    std::string text;
    for (const double number : numbers) text += (text.empty() ? "" : between) + text_of(number);
    return text;
}

// Returns "[[a, b], [c, d]]".
std::string nested(const Numbers& numbers, std::size_t columns) {
    std::string text;
    for (std::size_t i = 0; i < numbers.size(); i += columns)
        text +=
            (i > 0 ? ", [" : "[") + joined(Numbers(numbers.begin() + i, numbers.begin() + i + columns)) + "]";
    return "[" + text + "]";
}

Numbers scaled(Numbers numbers, double by) {
    for (double& number : numbers) number *= by;
    return numbers;
}

// Returns a 4x4 matrix.
Numbers rigid(const Numbers& r, const Numbers& t) {
    return {r[0], r[1], r[2], t[0], r[3], r[4], r[5], t[1], r[6], r[7], r[8], t[2], 0, 0, 0, 1};
}

Numbers turned_back(const Numbers& r) {
    return {r[0], r[3], r[6], r[1], r[4], r[7], r[2], r[5], r[8]};
}

// Returns the translation of the inverse movement.
Numbers moved_back(const Numbers& r, const Numbers& t) {
    return {-(r[0] * t[0] + r[3] * t[1] + r[6] * t[2]), -(r[1] * t[0] + r[4] * t[1] + r[7] * t[2]),
            -(r[2] * t[0] + r[5] * t[1] + r[8] * t[2])};
}

void expect_near(const Numbers& found, const Numbers& expected, const std::string& what) {
    ASSERT_EQ(found.size(), expected.size()) << what;
    for (std::size_t i = 0; i < found.size(); ++i)
        EXPECT_NEAR(found[i], expected[i], 1e-9) << what << " " << i;
}

template <std::size_t Count>
Numbers list_of(const std::array<double, Count>& values) {
    return {values.begin(), values.end()};
}

void expect_pair(const std::optional<StereoCalibrationFile>& file, const std::string& format,
                 const Numbers& left_lens = kLeftLens, const Numbers& right_lens = kRightLens) {
    ASSERT_TRUE(file) << format;
    const StereoCalibration& pair = file->calibration;
    EXPECT_EQ(file->format, format);
    expect_near(list_of(pair.left.matrix), kLeft, format + " left");
    expect_near(list_of(pair.right.matrix), kRight, format + " right");
    expect_near(pair.left.distortion, left_lens, format + " left lens");
    expect_near(pair.right.distortion, right_lens, format + " right lens");
    expect_near(list_of(pair.rotation), kTurn, format + " rotation");
    expect_near(list_of(pair.translation), kMove, format + " translation");
}

std::optional<StereoCalibrationFile> read(const std::string& text, int width = 0, int height = 0) {
    const Folder folder;
    return read_stereo_calibration({folder.write("rig", text), {}, width, height}, Rectify::automatic);
}

const std::string kJson =
    "{\"cameraMatrix1\": " + nested(kLeft, 3) + ", \"distCoeffs1\": " + nested(kLeftLens, 5) +
    ", \"cameraMatrix2\": " + nested(kRight, 3) + ", \"distCoeffs2\": " + nested(kRightLens, 5) +
    ", \"R\": " + nested(kTurn, 3) + ", \"T\": " + nested(kMove, 1) + "}";

TEST(ReadPairFormats, JsonInOneLineAndNested) {
    expect_pair(read(kJson), "OpenCV");
    std::string lines;
    for (const char c : kJson) lines += c == '[' || c == ',' ? std::string(1, c) + "\n " : std::string(1, c);
    expect_pair(read(lines), "OpenCV");
}

std::string xml_matrix(const std::string& name, int rows, int columns, const Numbers& numbers) {
    return "<" + name + " type_id=\"opencv-matrix\">\n  <rows>" + std::to_string(rows) + "</rows>\n  <cols>" +
           std::to_string(columns) + "</cols>\n  <dt>d</dt>\n  <data>\n    " + joined(numbers, " ") +
           "</data></" + name + ">\n";
}

const std::string kXml =
    "<?xml version=\"1.0\"?>\n<opencv_storage>\n<!-- left -->\n<image_size>\n  640 480</image_size>\n" +
    xml_matrix("K1", 3, 3, kLeft) + xml_matrix("D1", 1, 5, kLeftLens) + xml_matrix("K2", 3, 3, kRight) +
    xml_matrix("D2", 1, 5, kRightLens) + xml_matrix("R", 3, 3, kTurn) + xml_matrix("T", 3, 1, kMove) +
    "</opencv_storage>\n";

TEST(ReadPairFormats, FileStorageXml) {
    expect_pair(read(kXml), "OpenCV");
    EXPECT_EQ(read(kXml)->calibration.height, 480);
    for (std::size_t cut = 30; cut + 20 < kXml.size(); cut += 37)
        EXPECT_CONTAINS(error_of([&] { read(kXml.substr(0, cut)); }), "XML");
}

Bytes npy_of(const std::string& shape, const Numbers& numbers, const std::string& type = "<f8") {
    std::string header = "{'descr': '" + type + "', 'fortran_order': False, 'shape': " + shape + ", }";
    header += "\n";
    std::string head = std::string("\x93NUMPY\x01\0", 8);
    head += static_cast<char>(header.size() & 255);
    head += static_cast<char>(header.size() >> 8);
    return to_bytes(head + header) + bytes_of(numbers);
}

TEST(ReadPairFormats, Npz) {
    const std::vector<std::pair<std::string, Bytes>> arrays = {
        {"mtxL.npy", npy_of("(3, 3)", kLeft)},
        {"distL.npy", npy_of("(1, 5)", kLeftLens)},
        {"mtxR.npy", npy_of("(3, 3)", kRight)},
        {"distR.npy", npy_of("(5,)", kRightLens)},
        {"R.npy", npy_of("(3, 3)", kTurn)},
        {"T.npy", npy_of("(3, 1)", kMove)},
        {"rms.npy", npy_of("()", {0.3})},
        {"name.npy", npy_of("(2,)", {0, 0}, "<U2")},
        {"points.npy", npy_of("(40, 48, 2)", Numbers(3840))},
        {"corners.npy", npy_of("(2, 4, 3)", Numbers(24))}};
    const Folder folder;
    const auto path = folder.write("rig.npz", make_zip(arrays, true));
    expect_pair(read_stereo_calibration(path, Rectify::automatic), "OpenCV");
    Bytes cut = make_zip(arrays, false);
    cut.resize(cut.size() / 2);
    EXPECT_CONTAINS(error_of([&] { read_calibration_file(folder.write("cut.npz", cut)); }), "cut.npz");
    EXPECT_CONTAINS(error_of([&] { read_calibration_file(folder.write("no.npz", make_zip({}, false))); }),
                    "no.npz");
    const auto nan = make_zip({{"K.npy", npy_of("(3, 3)", Numbers(9, std::nan("")))}}, false);
    EXPECT_CONTAINS(error_of([&] { read_calibration_file(folder.write("nan.npz", nan)); }), "K is 'nan'");
}

TEST(ReadPairFormats, KalibrAndEuroc) {
    const auto camera = [](const std::string& name, const Numbers& k, const Numbers& lens) {
        return name + ":\n  camera_model: pinhole\n  distortion_model: radtan\n  distortion_coeffs: [" +
               joined(Numbers(lens.begin(), lens.begin() + 4)) + "]\n  intrinsics: [" +
               joined({k[0], k[4], k[2], k[5]}) + "]\n  resolution: [640, 480]\n";
    };
    const Numbers left(kLeftLens.begin(), kLeftLens.begin() + 4),
        right(kRightLens.begin(), kRightLens.begin() + 4);
    const std::string chain = camera("cam0", kLeft, kLeftLens) + camera("cam1", kRight, kRightLens) +
                              "  T_cn_cnm1: " + nested(rigid(kTurn, kMove), 4) + "\n";
    expect_pair(read(chain), "Kalibr", left, right);
    EXPECT_FALSE(read(chain)->calibration.is_fisheye);
    EXPECT_EQ(read(chain)->calibration.width, 640);
    std::string fisheye = chain;
    for (std::size_t at; (at = fisheye.find("radtan")) != std::string::npos;)
        fisheye.replace(at, 6, "equidistant");
    EXPECT_TRUE(read(fisheye)->calibration.is_fisheye);
    fisheye.replace(fisheye.find("pinhole"), 7, "omni");
    EXPECT_CONTAINS(error_of([&] { read(fisheye); }), "'omni'");

    // T_BS leads from a camera to the body: the left one's is the identity, the right one's the way back.
    const auto sensor = [](const Numbers& pose, const Numbers& k, const Numbers& lens) {
        return "sensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: [" + joined(pose) +
               "]\nrate_hz: 20\nresolution: [640, 480]\ncamera_model: pinhole\nintrinsics: [" +
               joined({k[0], k[4], k[2], k[5]}) +
               "]\ndistortion_model: radial-tangential\ndistortion_coefficients: [" +
               joined(Numbers(lens.begin(), lens.begin() + 4)) + "]\n";
    };
    const Folder folder;
    std::filesystem::create_directories(folder.path() / "cam0");
    std::filesystem::create_directories(folder.path() / "cam1");
    const auto first = folder.write("cam0/sensor.yaml",
                                    sensor(rigid({1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}), kLeft, kLeftLens));
    EXPECT_FALSE(read_stereo_calibration(first, Rectify::automatic));
    EXPECT_NEAR(read_calibration_file(first).calibration.focal_px, 500, 1e-9);
    const auto second = folder.write(
        "cam1/sensor.yaml", sensor(rigid(turned_back(kTurn), moved_back(kTurn, kMove)), kRight, kRightLens));
    const auto beside = read_stereo_calibration(first, Rectify::automatic);
    expect_pair(beside, "EuRoC", left, right);
    EXPECT_EQ(beside->other, second);
    expect_pair(read_stereo_calibration({first, second, 0, 0}, Rectify::automatic), "EuRoC", left, right);
    EXPECT_NEAR(read_calibration_file(first).calibration.focal_px, 500,
                1e-9);  // one view does not need the other
}

TEST(ReadPairFormats, IntrinsicsAndExtrinsicsAreTwoFiles) {
    const Folder folder;
    const auto first = folder.write(
        "intrinsics.yml", "M1: " + nested(kLeft, 3) + "\nD1: " + nested(kLeftLens, 5) +
                              "\nM2: " + nested(kRight, 3) + "\nD2: " + nested(kRightLens, 5) + "\n");
    EXPECT_CONTAINS(error_of([&] { read_stereo_calibration(first, Rectify::automatic); }), "R is missing");
    const std::string movement = "R: " + nested(kTurn, 3) + "\nT: " + nested(kMove, 1) + "\n";
    const auto named = folder.write("movement.yml", movement);
    expect_pair(read_stereo_calibration({first, named, 0, 0}, Rectify::automatic), "OpenCV");
    folder.write("extrinsics.yml", movement);
    expect_pair(read_stereo_calibration(first, Rectify::automatic), "OpenCV");
    const auto kitti =
        folder.write("kitti.txt", "P0: 7 0 6 0 0 7 1 0 0 0 1 0\nP1: 7 0 6 -3 0 7 1 0 0 0 1 0\n");
    EXPECT_CONTAINS(error_of([&] { read_calibration_file({kitti, named, 0, 0}); }), "does not go with");
}

std::string ros(const Numbers& k, const Numbers& lens, const Numbers& turn, const Numbers& p) {
    const auto matrix = [](const std::string& name, int rows, const Numbers& numbers) {
        return name + ":\n  rows: " + std::to_string(rows) +
               "\n  cols: " + std::to_string(numbers.size() / static_cast<std::size_t>(rows)) +
               "\n  data: [" + joined(numbers) + "]\n";
    };
    return "image_width: 640\nimage_height: 480\ncamera_name: one\ndistortion_model: plumb_bob\n" +
           matrix("camera_matrix", 3, k) + matrix("distortion_coefficients", 1, lens) +
           matrix("rectification_matrix", 3, turn) + matrix("projection_matrix", 3, p);
}

// The rectified cameras look along the right camera's axis x, so its own rectification is no turn.
TEST(ReadPairFormats, RosFilesOfBothCameras) {
    const Numbers none = {1, 0, 0, 0, 1, 0, 0, 0, 1}, left_p = {400, 0, 310, 0, 0, 400, 230, 0, 0, 0, 1, 0},
                  right_p = {400, 0, 310, -48, 0, 400, 230, 0, 0, 0, 1, 0};
    const Folder folder;
    const auto left = folder.write("left.yaml", ros(kLeft, kLeftLens, kTurn, left_p));
    EXPECT_FALSE(read_stereo_calibration(left, Rectify::automatic));
    EXPECT_EQ(read_calibration_file(left).calibration.baseline_m, 0);
    folder.write("right.yaml", ros(kRight, kRightLens, none, right_p));
    const auto pair = read_stereo_calibration(left, Rectify::automatic);
    ASSERT_TRUE(pair);
    EXPECT_TRUE(pair->is_rectified);
    EXPECT_EQ(pair->other.filename(), "right.yaml");
    expect_near(list_of(pair->calibration.rotation), kTurn, "rotation");
    expect_near(list_of(pair->calibration.translation), {-0.12, 0, 0}, "translation");
    const CalibrationFile rectified = read_calibration_file(left);
    EXPECT_NEAR(rectified.calibration.baseline_m, 0.12, 1e-12);
    EXPECT_NEAR(rectified.calibration.focal_px, 400, 1e-12);
    EXPECT_EQ(rectified.other.filename(), "right.yaml");
}

TEST(ReadPairFormats, ZedTakesTheSectionOfThePicturesSize) {
    const auto camera = [](const std::string& name, const Numbers& k, const Numbers& lens, double scale) {
        return "[" + name + "]\nfx=" + text_of(k[0] * scale) + "\nfy=" + text_of(k[4] * scale) +
               "\ncx=" + text_of(k[2] * scale) + "\ncy=" + text_of(k[5] * scale) +
               "\nk1=" + text_of(lens[0]) + "\nk2=" + text_of(lens[1]) + "\np1=" + text_of(lens[2]) +
               "\np2=" + text_of(lens[3]) + "\nk3=" + text_of(lens[4]) + "\n\n";
    };
    const std::string angle = text_of(std::asin(0.6));
    const std::string conf =
        camera("LEFT_CAM_HD", kLeft, kLeftLens, 1) + camera("RIGHT_CAM_HD", kRight, kRightLens, 1) +
        camera("LEFT_CAM_FHD", kLeft, kLeftLens, 1.5) + camera("RIGHT_CAM_FHD", kRight, kRightLens, 1.5) +
        "[STEREO]\nBaseline=120\nTY=-2\nTZ=-3\nCV_HD=" + angle + "\nCV_FHD=9\nRX_HD=0\nRZ_HD=0\n";
    expect_pair(read(conf, 1280, 720), "ZED");
    EXPECT_EQ(read(conf, 1280, 720)->calibration.width, 1280);
    EXPECT_EQ(read(conf, 1920, 1080)->calibration.left.matrix[0], 750);
    EXPECT_EQ(read(conf, 640, 360)->calibration.width, 1920);  // the largest of the aspect, to be scaled
    EXPECT_CONTAINS(error_of([&] { read(conf, 640, 480); }), "1280x720, 1920x1080 px");
    std::string without = conf;
    without.erase(without.find("TY=-2\n"), 6);
    EXPECT_CONTAINS(error_of([&] { read(without, 1280, 720); }), "x, y and z");
}

std::string oak(const std::string& socket, const Numbers& k, const Numbers& lens, int to,
                const Numbers& move) {
    return "[" + socket + ", {\"cameraType\": 0, \"distortionCoeff\": [" + joined(lens) +
           "], \"extrinsics\": {\"rotationMatrix\": " + nested(kTurn, 3) +
           ", \"specTranslation\": {\"x\": 1, \"y\": 1, \"z\": 1}, \"toCameraSocket\": " +
           std::to_string(to) + ", \"translation\": {\"x\": " + text_of(move[0]) +
           ", \"y\": " + text_of(move[1]) + ", \"z\": " + text_of(move[2]) +
           "}}, \"height\": 400, \"intrinsicMatrix\": " + nested(k, 3) +
           ", \"lensPosition\": 0, \"width\": 640}]";
}

TEST(ReadPairFormats, OakCountsCentimetres) {
    Numbers left = kLeftLens, right = kRightLens;
    left.resize(14);
    right.resize(14);
    const auto file = [&](int to) {
        return "{\"batchName\": \"\", \"cameraData\": [" + oak("0", kLeft, right, -1, {0, 0, 0}) + ", " +
               oak("1", kLeft, left, to, scaled(kMove, 100)) + ", " + oak("2", kRight, right, 0, {5, 5, 5}) +
               "], \"stereoRectificationData\": {\"leftCameraSocket\": 1, \"rightCameraSocket\": 2}}";
    };
    const auto pair = read(file(2));
    expect_pair(pair, "OAK-D", left, right);
    ASSERT_EQ(pair->told.size(), 1u);
    EXPECT_CONTAINS(pair->told[0], "centimetres");
    EXPECT_EQ(pair->calibration.height, 400);
    EXPECT_CONTAINS(error_of([&] { read(file(0)); }), "toCameraSocket");
}

TEST(ReadPairFormats, RealSense) {
    const std::string table =
        "{\"baseline\": -50, \"intrinsic_left.x.x\": 0.5, \"rectified.0.fx\": \"960\", \"rectified.0.fy\": "
        "960, "
        "\"rectified.0.ppx\": 970, \"rectified.0.ppy\": 530, \"rectified.0.width\": 1920, "
        "\"rectified.0.height\": "
        "1080, \"rectified.1.fx\": 420, \"rectified.1.fy\": 420, \"rectified.1.ppx\": 424, "
        "\"rectified.1.ppy\": "
        "235, \"rectified.1.width\": 848, \"rectified.1.height\": 480, \"rectified.2.fx\": 0, "
        "\"rectified.2.width\": 640, \"rectified.2.height\": 400}";
    const Folder folder;
    const auto path = folder.write("d400.json", table);
    EXPECT_FALSE(read_stereo_calibration(path, Rectify::automatic));
    const CalibrationFile file = read_calibration_file({path, {}, 848, 480});
    EXPECT_EQ(file.format, "RealSense D400 table");
    EXPECT_NEAR(file.calibration.focal_px, 420, 1e-12);
    EXPECT_NEAR(file.calibration.baseline_m, 0.05, 1e-12);
    EXPECT_NEAR(file.calibration.cx, 424.5, 1e-12);
    EXPECT_EQ(read_calibration_file(path).calibration.width, 1920);
    EXPECT_CONTAINS(error_of([&] { read_calibration_file({path, {}, 640, 400}); }), "848x480 px");

    const auto param = [](const std::string& name, const Numbers& numbers) {
        std::string values;
        for (const double number : numbers) values += "<value>" + text_of(number) + "</value>";
        return "<param name = \"" + name + "\">" + values + "</param>\n";
    };
    expect_pair(read("<?xml version=\"1.0\"?>\n<Config>\n" + param("ResolutionLeftRight", {640, 480}) +
                     param("FocalLengthLeft", {500, 500}) + param("PrincipalPointLeft", {320, 240}) +
                     param("DistortionLeft", kLeftLens) + param("FocalLengthRight", {510, 510}) +
                     param("PrincipalPointRight", {318, 242}) + param("DistortionRight", kRightLens) +
                     param("RotationLeftRight", kTurn) + param("TranslationLeftRight", scaled(kMove, 1000)) +
                     "</Config>\n"),
                "RealSense calibration tool");
}

TEST(ReadPairFormats, MatlabCountsPixelsFromOneAndMillimetres) {
    const auto camera = [](Numbers k, const Numbers& lens) {
        k[2] += 1;
        k[5] += 1;
        return "{\"RadialDistortion\": [" + joined({lens[0], lens[1], lens[4]}) +
               "], \"TangentialDistortion\": [" + joined({lens[2], lens[3]}) +
               "], \"ImageSize\": [480, 640], \"IntrinsicMatrix\": " + nested(turned_back(k), 3) + "}";
    };
    const auto pair = read("{\"CameraParameters1\": " + camera(kLeft, kLeftLens) +
                           ", \"CameraParameters2\": " + camera(kRight, kRightLens) +
                           ", \"RotationOfCamera2\": " + nested(turned_back(kTurn), 3) +
                           ", \"TranslationOfCamera2\": [" + joined(scaled(kMove, 1000)) + "]}");
    expect_pair(pair, "MATLAB");
    EXPECT_EQ(pair->calibration.width, 640);
    EXPECT_CONTAINS(pair->told.at(0), "millimetres");

    const auto column = [](const std::string& name, const Numbers& numbers) {
        return name + " = [ " + joined(numbers, " ; ...\n ") + " ];\n";
    };
    const std::string toolbox = "% Intrinsic parameters of left camera:\n" + column("fc_left", {500, 500}) +
                                column("cc_left", {320, 240}) + "alpha_c_left = [ 0.0 ];\n" +
                                column("kc_left", kLeftLens) + column("fc_right", {510, 510}) +
                                column("cc_right", {318, 242}) + column("kc_right", kRightLens) +
                                column("om", {0, std::asin(0.6), 0}) + column("T", scaled(kMove, 1000));
    expect_pair(read(toolbox), "Bouguet's toolbox");
    EXPECT_CONTAINS(error_of([&] { read(toolbox.substr(0, toolbox.size() - 5)); }), "truncated");
}

TEST(ReadPairFormats, OrbSlam) {
    const std::string lengths =
        "Camera.fx: 400\nCamera.fy: 400\nCamera.cx: 310\nCamera.cy: 230\nCamera.width: "
        "640\nCamera.height: 480\nCamera.bf: 48\n";
    const Folder folder;
    const auto plain = folder.write("orb.yaml", "%YAML:1.0\n" + lengths);
    EXPECT_FALSE(read_stereo_calibration(plain, Rectify::automatic));
    EXPECT_NEAR(read_calibration_file(plain).calibration.baseline_m, 0.12, 1e-12);
    EXPECT_EQ(read_calibration_file(plain).format, "ORB-SLAM");

    const auto side = [](const std::string& name, const Numbers& k, const Numbers& lens, const Numbers& turn,
                         double x) {
        return name + ".D: " + nested(lens, 5) + "\n" + name + ".K: " + nested(k, 3) + "\n" + name +
               ".R: " + nested(turn, 3) + "\n" + name + ".P: [400, 0, 310, " + text_of(x) +
               ", 0, 400, 230, 0, 0, 0, 1, 0]\n";
    };
    const Numbers none = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    const auto both = read(lengths + side("LEFT", kLeft, kLeftLens, kTurn, 0) +
                           side("RIGHT", kRight, kRightLens, none, -48));
    ASSERT_TRUE(both);
    EXPECT_TRUE(both->is_rectified);
    expect_near(list_of(both->calibration.left.matrix), kLeft, "left");
    expect_near(list_of(both->calibration.rotation), kTurn, "rotation");

    const auto third = [](const std::string& name, const Numbers& k, const Numbers& lens) {
        return name + ".fx: " + text_of(k[0]) + "\n" + name + ".fy: " + text_of(k[4]) + "\n" + name +
               ".cx: " + text_of(k[2]) + "\n" + name + ".cy: " + text_of(k[5]) + "\n" + name +
               ".k1: " + text_of(lens[0]) + "\n" + name + ".k2: " + text_of(lens[1]) + "\n" + name +
               ".p1: " + text_of(lens[2]) + "\n" + name + ".p2: " + text_of(lens[3]) + "\n" + name +
               ".k3: " + text_of(lens[4]) + "\n";
    };
    expect_pair(read("Camera.type: \"PinHole\"\n" + third("Camera1", kLeft, kLeftLens) +
                     third("Camera2", kRight, kRightLens) + "Stereo.T_c1_c2: " +
                     nested(rigid(turned_back(kTurn), moved_back(kTurn, kMove)), 4) + "\n"),
                "ORB-SLAM");
}

}  // namespace
}  // namespace hexrelief::readers
