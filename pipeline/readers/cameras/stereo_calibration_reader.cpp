#include "pipeline/readers/cameras/stereo_calibration_reader.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <tuple>

#include "pipeline/readers/cameras/yaml_values.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::readers {
namespace {

using codec::CalibrationText;
using codec::refuse_key;

constexpr std::array<const char*, 2> kMatrices[] = {
    {"K1", "K2"}, {"M1", "M2"}, {"cameraMatrix1", "cameraMatrix2"}, {"camera_matrix1", "camera_matrix2"}};
constexpr std::array<const char*, 2> kDistortions[] = {
    {"D1", "D2"}, {"distCoeffs1", "distCoeffs2"}, {"dist_coeffs1", "dist_coeffs2"}};

// Returns the file's name for this camera's entry, 0 = left; empty if the file has none.
template <std::size_t Count>
std::string key_of(const YAML::Node& root, const std::array<const char*, 2> (&names)[Count], int camera) {
    for (const auto& pair : names)
        if (root[pair[camera]].IsDefined()) return pair[camera];
    return {};
}

// True if a line begins with one of the keys. Searched as text, because a file in another format
// need not be YAML.
bool has_pair_keys(std::string_view text) {
    for (std::string_view line : codec::lines(text)) {
        line = codec::trim(line);
        if (line.starts_with('"')) line.remove_prefix(1);
        for (const auto& names : {kMatrices[0], kMatrices[1], kMatrices[2], kMatrices[3], kDistortions[0]})
            for (const char* name : names)
                if (line.starts_with(name) && line.find(':') != std::string_view::npos) return true;
    }
    return false;
}

std::string require_key(const CalibrationText& source, std::string key, const char* name, const char* what) {
    if (key.empty())
        codec::refuse_key(source, name, std::string("is missing; rectifying a pair needs ") + what);
    return key;
}

StereoCalibration::Camera read_camera(const CalibrationText& source, const YAML::Node& root, int camera) {
    StereoCalibration::Camera read;
    const char* const k_name = camera == 0 ? "K1" : "K2";
    const char* const d_name = camera == 0 ? "D1" : "D2";
    const std::string key = require_key(source, key_of(root, kMatrices, camera), k_name, "K1 and K2");
    const std::vector<double> matrix = codec::read_numbers(source, key, root[key], 3, 3);
    const codec::Pinhole pinhole = codec::from_matrix(source, key, matrix);
    if (!(pinhole.fx > 0) || !(pinhole.fy > 0))
        codec::refuse_key(source, key, "has a focal length that is not above 0");
    read.matrix = {pinhole.fx, 0, pinhole.cx, 0, pinhole.fy, pinhole.cy, 0, 0, 1};
    const std::string d = require_key(source, key_of(root, kDistortions, camera), d_name,
                                      "D1 and D2 (zeros where the lenses do not distort)");
    const YAML::Node data = root[d].IsMap() ? root[d]["data"] : root[d];
    if (!data.IsDefined() || !data.IsSequence()) codec::refuse_key(source, d, "must hold a list of numbers");
    for (const YAML::Node& item : data) read.distortion.push_back(codec::number_of(source, d, item));
    constexpr std::size_t counts[] = {0, 4, 5, 8, 12, 14};
    if (std::find(std::begin(counts), std::end(counts), read.distortion.size()) == std::end(counts))
        codec::refuse_key(
            source, d,
            "has " + std::to_string(read.distortion.size()) + " numbers; OpenCV has 4, 5, 8, 12 or 14");
    return read;
}

void check_rotation(const CalibrationText& source, const std::array<double, 9>& r) {
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            double product = 0;
            for (int k = 0; k < 3; ++k) product += r[3 * i + k] * r[3 * j + k];
            if (!(std::abs(product - (i == j)) < 0.001))
                codec::refuse_key(source, "R", "is no rotation matrix");
        }
    const double determinant = r[0] * (r[4] * r[8] - r[5] * r[7]) - r[1] * (r[3] * r[8] - r[5] * r[6]) +
                               r[2] * (r[3] * r[7] - r[4] * r[6]);
    if (determinant < 0) codec::refuse_key(source, "R", "is no rotation matrix: it mirrors");
}

bool is_fisheye(CalibrationText& source, const YAML::Node& root, const StereoCalibration& calibration) {
    const bool four = calibration.left.distortion.size() == 4 && calibration.right.distortion.size() == 4;
    for (const char* key : {"model", "camera_model", "distortion_model"}) {
        if (!root[key].IsDefined() || !root[key].IsScalar()) continue;
        std::string name = root[key].Scalar();
        for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        if (name != "fisheye" && name != "equidistant" && name != "kannala_brandt") return false;
        if (!four)
            codec::refuse_key(source, "D1 or D2", "is not of 4 numbers, as the fisheye model has them");
        return true;
    }
    if (four)
        source.told.push_back(
            "4 numbers of distortion are taken for cv::fisheye's; where they are k1, k2, p1, p2, add the "
            "line "
            "model: pinhole");
    return four;
}

StereoCalibration read_tree(CalibrationText& source, const YAML::Node& root) {
    StereoCalibration calibration;
    calibration.left = read_camera(source, root, 0);
    calibration.right = read_camera(source, root, 1);
    for (const char* key : {"R", "T"})
        if (!root[key].IsDefined())
            codec::refuse_key(
                source, key,
                "is missing; rectifying a pair needs R and T between the cameras, which OpenCV's sample "
                "writes into extrinsics.yml: copy them into this file");
    const std::vector<double> r = codec::read_numbers(source, "R", root["R"], 3, 3);
    std::copy(r.begin(), r.end(), calibration.rotation.begin());
    check_rotation(source, calibration.rotation);
    const YAML::Node t = root["T"].IsMap() ? root["T"]["data"] : root["T"];
    if (!t.IsDefined() || !t.IsSequence() || t.size() != 3)
        codec::refuse_key(source, "T", "must hold 3 numbers");
    for (int i = 0; i < 3; ++i) calibration.translation[i] = codec::number_of(source, "T", t[i]);
    calibration.is_fisheye = is_fisheye(source, root, calibration);
    std::tie(calibration.width, calibration.height) = codec::size_of(source, root);
    return calibration;
}

}  // namespace

std::optional<StereoCalibrationFile> read_stereo_calibration(const std::filesystem::path& path,
                                                             Rectify rectify) {
    if (rectify == Rectify::never) return std::nullopt;
    CalibrationText source = codec::load_calibration_text(path);
    if (!has_pair_keys(source.text)) {
        if (rectify == Rectify::automatic) return std::nullopt;
        codec::refuse_key(source, "K1, D1, K2, D2, R and T", "must be there to rectify the pair");
    }
    std::optional<StereoCalibrationFile> file;
    codec::with_yaml_tree(source, [&](const YAML::Node& root) {
        if (!root.IsMap()) return;
        const bool is_rectified = root["Q"].IsDefined() || (root["P1"].IsDefined() && root["P2"].IsDefined());
        if (is_rectified && rectify == Rectify::automatic) return;
        StereoCalibration calibration = read_tree(source, root);
        file = {std::move(calibration), source.told};
    });
    return file;
}

}  // namespace hexrelief::readers
