// Parses OpenCV's FileStorage YAML, and hexrelief's own keys.
#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

#include "pipeline/readers/cameras/yaml_values.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::readers::codec {
namespace {

Projection read_projection(const CalibrationText& source, const std::string& key, const YAML::Node& node) {
    Projection projection;
    const std::vector<double> values = read_matrix(source, key, node, 3, 4);
    std::copy(values.begin(), values.end(), projection.begin());
    return projection;
}

// Uses Q of cv::stereoRectify: Z = q23 / (q32 d + q33), so 1 / q32 is the baseline and q33 / q32 the offset.
Calibration from_q(CalibrationText& source, const YAML::Node& node) {
    const std::vector<double> q = read_matrix(source, "Q", node, 4, 4);
    if (q[14] == 0)
        refuse_key(source, "Q", "has 0 in row 4, column 3 (1 / baseline): not of a horizontal stereo pair");
    require_one_focal(source, "Q's row 1 and row 2", q[0], q[5]);
    if (q[0] == 0) refuse_key(source, "Q", "has 0 in row 1, column 1; it must be 1");
    Calibration calibration;
    calibration.focal_px = q[11] / q[0];
    calibration.cx = -q[3] / q[0] + kPixelCentre;
    calibration.cy = -q[7] / q[0] + kPixelCentre;
    calibration.baseline_m = q[0] / q[14];
    calibration.doffs_px = q[15] / q[14];
    return calibration;
}

Calibration from_pair(CalibrationText& source, const YAML::Node& left, const YAML::Node& right) {
    Projection l = read_projection(source, "P1", left);
    const Projection r = read_projection(source, "P2", right);
    l[0] = require_square(source, "P1", l[0], l[5]);
    require_one_focal(source, "P1 and P2", l[0], r[0]);
    if (l[0] == 0 || r[0] == 0) refuse_key(source, "P1 or P2", "has the focal length 0");
    if (r[3] == 0 && r[7] != 0)
        refuse_key(source, "P2", "is of a vertical pair; only horizontal pairs are read");
    return from_projections(l, r);
}

Calibration from_own_keys(CalibrationText& source, const YAML::Node& root) {
    Calibration calibration;
    int width = 0, height = 0;
    bool has_cx = false, has_cy = false, has_focal = false;
    source.format = "hexrelief";
    source.has_baseline = false;
    std::vector<std::string> seen;
    for (const auto& entry : root) {
        const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "a key";
        if (std::find(seen.begin(), seen.end(), key) != seen.end()) {
            refuse_key(source, excerpt(key), "is given twice; keep one");
        }
        seen.push_back(key);
        const auto number = [&] { return number_of(source, key, entry.second); };
        if (key == "focal_px") {
            calibration.focal_px = number(), has_focal = true;
        } else if (key == "baseline_m") {
            calibration.baseline_m = number(), source.has_baseline = true;
        } else if (key == "cx") {
            calibration.cx = number(), has_cx = true;
        } else if (key == "cy") {
            calibration.cy = number(), has_cy = true;
        } else if (key == "doffs_px") {
            calibration.doffs_px = number();
        } else if (key == "width") {
            width = require_side(source, key, number());
        } else if (key == "height") {
            height = require_side(source, key, number());
        } else {
            refuse_key(source, excerpt(key),
                       "is not known; the keys are focal_px, baseline_m, cx, cy, doffs_px, width, height");
        }
    }
    if (!has_focal) refuse_key(source, "focal_px", "is missing; give the focal length in pixels");
    if ((width == 0) != (height == 0)) refuse_key(source, "width and height", "must be given together");
    if (has_cx != has_cy)
        refuse_key(source, "cx and cy", "must be given together; without both the centre is taken");
    if (!has_cx) {
        calibration.cx = width > 0 ? width / 2.0 : std::nan("");
        calibration.cy = height > 0 ? height / 2.0 : std::nan("");
    }
    calibration.width = width;
    calibration.height = height;
    return calibration;
}

// Removes FileStorage's first line "%YAML:1.0", which is not a valid YAML directive.
std::string without_directive(const std::string& text) {
    const std::size_t start = text.find_first_not_of(" \t\r\n");
    if (start == std::string::npos || text.compare(start, 5, "%YAML") != 0) return text;
    const std::size_t end = text.find('\n', start);
    return end == std::string::npos ? std::string() : text.substr(end + 1);
}

std::optional<Calibration> parse_tree(CalibrationText& source, const YAML::Node& root) {
    if (!root.IsMap()) return std::nullopt;
    if (root["focal_px"].IsDefined() || root["baseline_m"].IsDefined()) return from_own_keys(source, root);
    const bool opencv =
        source.text.starts_with("%YAML") || source.text.find("opencv-matrix") != std::string::npos;
    Calibration calibration;
    if (root["Q"].IsDefined()) {
        calibration = from_q(source, root["Q"]);
    } else if (root["P1"].IsDefined() && root["P2"].IsDefined()) {
        calibration = from_pair(source, root["P1"], root["P2"]);
    } else if (const auto camera = parse_camera_tree(source, root)) {
        return camera;
    } else if (opencv) {
        refuse_key(source, "Q, or P1 and P2,",
                   "must be there; save what cv::stereoRectify returned, or give both "
                   "pictures with K1, D1, K2, D2, R and T, and they are rectified");
    } else {
        return std::nullopt;
    }
    source.format = "OpenCV";
    std::tie(calibration.width, calibration.height) = size_of(source, root);
    return calibration;
}

}  // namespace

void with_yaml_tree(const CalibrationText& source, const std::function<void(const YAML::Node&)>& read) {
    try {
        read(YAML::Load(without_directive(source.text)));
    } catch (const YAML::Exception& failure) {
        const std::string where =
            failure.mark.is_null() ? "" : "line " + std::to_string(failure.mark.line + 1) + ": ";
        refuse_key(source, where + printable(failure.msg, 200) + ";",
                   "it must be a calibration as Middlebury, KITTI, OpenCV YAML or focal_px "
                   "keys; see the formats in the manual");
    }
}

std::optional<Calibration> parse_yaml(CalibrationText& source) {
    std::optional<Calibration> calibration;
    with_yaml_tree(source, [&](const YAML::Node& root) { calibration = parse_tree(source, root); });
    return calibration;
}

}  // namespace hexrelief::readers::codec
