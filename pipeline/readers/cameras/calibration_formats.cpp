#include "pipeline/readers/cameras/calibration_formats.h"

#include <cmath>

#include "pipeline/readers/codecs.h"
#include "pipeline/readers/parse_text.h"
#include "pipeline/readers/source.h"

namespace hexrelief::readers::codec {

namespace {

std::string matrix_text(const SourceFile& source) {
    std::string text;
    for (const double number : read_npy_numbers(source)) text += exact_text(number) + " ";
    return text;
}

}  // namespace

CalibrationText load_calibration_text(const std::filesystem::path& path) {
    constexpr std::uintmax_t longest = 1u << 20;  // lists of thousands of poses are longer than a calibration
    const SourceFile source = load_file(path, longest);
    std::string text(source.bytes.begin(), source.bytes.end());
    if (text.starts_with("\x93NUMPY")) text = matrix_text(source);
    if (auto colmap = text_of_colmap(source.bytes)) text = std::move(*colmap);
    if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);
    if (text.find('\0') != std::string::npos && !text.starts_with("PK\3\4"))
        refuse(path, "it is a binary file, not a calibration; give calib.txt, KITTI or OpenCV YAML");
    CalibrationText loaded;
    loaded.path = path;
    loaded.text = std::move(text);
    return loaded;
}

void refuse_key(const CalibrationText& source, std::string_view key, const std::string& reason) {
    refuse(source.path, std::string(key) + " " + reason);
}

double require_number(const CalibrationText& source, std::string_view key, std::string_view text) {
    if (const auto value = parse_number(text)) return *value;
    refuse_key(source, key, "is " + excerpt(trim(text)) + "; it must be a finite number");
}

int require_side(const CalibrationText& source, std::string_view key, double value) {
    if (value >= 1 && value <= 1e9 && value == std::floor(value)) return static_cast<int>(value);
    refuse_key(source, key, "must be a whole number of pixels, at least 1");
}

double require_square(CalibrationText& source, std::string_view key, double fx, double fy) {
    if (fx == fy) return fx;
    const std::string lengths = "focal lengths " + number_text(fx) + " and " + number_text(fy);
    if (!(std::abs(fx - fy) <= 0.01 * std::abs(fx)))
        refuse_key(source, key, "has " + lengths + "; pixels must be square, scale the images first");
    source.told.push_back(std::string(key) + " has " + lengths + "; their mean is used");
    return 0.5 * (fx + fy);
}

void require_one_focal(const CalibrationText& source, std::string_view key, double left, double right) {
    if (std::abs(left - right) <= 0.005 * std::abs(left)) return;
    refuse_key(source, key,
               "have focal lengths " + number_text(left) + " and " + number_text(right) +
                   "; rectified images have one");
}

Calibration from_projections(const Projection& left, const Projection& right) {
    Calibration calibration;
    calibration.focal_px = left[0];
    calibration.cx = left[2] + kPixelCentre;
    calibration.cy = left[6] + kPixelCentre;
    calibration.baseline_m = left[3] / left[0] - right[3] / right[0];
    calibration.doffs_px = right[2] - left[2];
    return calibration;
}

std::vector<double> upper_left(const std::vector<double>& m) {
    if (m.size() == 9) return m;
    return {m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]};
}

Pinhole from_matrix(const CalibrationText& source, std::string_view key, const std::vector<double>& matrix) {
    if (matrix.size() != 9)
        refuse_key(source, key, "has " + std::to_string(matrix.size()) + " numbers; a 3x3 matrix has 9");
    const bool by_columns = matrix[2] == 0 && matrix[5] == 0;
    const auto at = [&](int row, int column) {
        return matrix[static_cast<std::size_t>(by_columns ? column * 3 + row : row * 3 + column)];
    };
    if (at(2, 0) != 0 || at(2, 1) != 0 || at(2, 2) != 1 || at(1, 0) != 0)
        refuse_key(source, key, "is no camera matrix; fx 0 cx, 0 fy cy, 0 0 1 is expected");
    if (std::abs(at(0, 1)) > 0.001 * std::abs(at(0, 0)))
        refuse_key(source, key, "has the skew " + number_text(at(0, 1)) + "; it must be 0");
    return {.fx = at(0, 0), .fy = at(1, 1), .cx = at(0, 2), .cy = at(1, 2)};
}

Calibration from_pinhole(CalibrationText& source, std::string_view key, const Pinhole& camera,
                         double pixel_centre) {
    source.has_baseline = false;
    Calibration calibration;
    calibration.focal_px = require_square(source, key, camera.fx, camera.fy);
    calibration.cx = camera.cx + pixel_centre;
    calibration.cy = camera.cy + pixel_centre;
    calibration.width = camera.width;
    calibration.height = camera.height;
    return calibration;
}

}  // namespace hexrelief::readers::codec
