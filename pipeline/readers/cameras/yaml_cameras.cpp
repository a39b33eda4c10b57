// Parses one camera in YAML or JSON, which yaml-cpp reads as YAML: ROS camera_info, Open3D,
// RealSense, or a matrix.
#include <cmath>
#include <tuple>

#include "pipeline/readers/cameras/yaml_values.h"

namespace hexrelief::readers::codec {

double number_of(const CalibrationText& source, const std::string& key, const YAML::Node& node) {
    if (!node.IsScalar()) refuse_key(source, key, "must be a number");
    return require_number(source, key, node.Scalar());
}

std::vector<double> read_matrix(const CalibrationText& source, const std::string& key, const YAML::Node& node,
                                int rows, int columns) {
    const std::string shape = std::to_string(rows) + "x" + std::to_string(columns);
    if (!node.IsMap() || !node["data"].IsDefined() || !node["data"].IsSequence()) {
        refuse_key(source, key, "must be an opencv-matrix of " + shape);
    }
    const YAML::Node data = node["data"];
    const bool fits = node["rows"].IsDefined() && node["cols"].IsDefined() &&
                      number_of(source, key + ".rows", node["rows"]) == rows &&
                      number_of(source, key + ".cols", node["cols"]) == columns &&
                      data.size() == static_cast<std::size_t>(rows) * columns;
    if (!fits)
        refuse_key(source, key, "must be an opencv-matrix of " + shape + " with as many numbers in data");
    std::vector<double> values;
    for (const YAML::Node& item : data) values.push_back(number_of(source, key, item));
    return values;
}

std::vector<double> read_numbers(const CalibrationText& source, const std::string& key,
                                 const YAML::Node& node, int rows, int columns) {
    if (node.IsMap()) return read_matrix(source, key, node, rows, columns);
    const std::size_t expected = static_cast<std::size_t>(rows) * columns;
    std::vector<double> values;
    if (node.IsSequence() && node.size() <= expected)
        for (const YAML::Node& item : node) {
            if (!item.IsSequence())
                values.push_back(number_of(source, key, item));
            else if (item.size() == static_cast<std::size_t>(columns))
                for (const YAML::Node& one : item) values.push_back(number_of(source, key, one));
        }
    if (values.size() != expected)
        refuse_key(source, key,
                   "must hold the " + std::to_string(expected) + " numbers of a " + std::to_string(rows) +
                       "x" + std::to_string(columns) + " matrix");
    return values;
}

std::pair<int, int> size_of(const CalibrationText& source, const YAML::Node& root) {
    const auto side = [&](const char* key, const YAML::Node& node) {
        return require_side(source, key, number_of(source, key, node));
    };
    for (const auto& [w, h] : {std::pair{"image_width", "image_height"}, {"width", "height"}})
        if (root[w].IsDefined() && root[h].IsDefined()) return {side(w, root[w]), side(h, root[h])};
    for (const char* key : {"image_size", "imageSize", "image_Size", "size"}) {
        const YAML::Node size = root[key];
        if (size.IsDefined() && size.IsSequence() && size.size() == 2)
            return {side(key, size[0]), side(key, size[1])};
    }
    return {0, 0};
}

namespace {

// Returns the first of `keys` that the map has, and its value; undefined if it has none.
std::pair<std::string, YAML::Node> find_key(const YAML::Node& root, std::initializer_list<const char*> keys) {
    for (const char* key : keys)
        if (root[key].IsDefined()) return {key, root[key]};
    return {"", YAML::Node(YAML::NodeType::Undefined)};
}

void tell_of_distortion(CalibrationText& source, const YAML::Node& root) {
    const auto [key, node] = find_key(root, {"distortion_coefficients", "D", "d", "coeffs"});
    if (key.empty()) return;
    const YAML::Node data = node.IsMap() ? node["data"] : node;
    bool any = false;
    if (data.IsDefined() && data.IsSequence())
        for (const YAML::Node& item : data) any = number_of(source, key, item) != 0 || any;
    if (any)
        source.told.push_back(key + " says that the camera distorts; the picture is taken for undistorted");
}

// Uses P of the rectified picture, else K of the picture as it was taken.
std::optional<Calibration> parse_ros(CalibrationText& source, const YAML::Node& root) {
    const auto [p_key, p_node] = find_key(root, {"projection_matrix", "P", "p"});
    const auto [k_key, k_node] = find_key(root, {"camera_matrix", "K", "k"});
    if (p_key.empty() || k_key.empty()) return std::nullopt;
    source.format = "ROS camera_info";
    Pinhole camera;
    std::tie(camera.width, camera.height) = size_of(source, root);
    const std::vector<double> p = read_numbers(source, p_key, p_node, 3, 4);
    if (p[0] == 0) {
        const Pinhole k = from_matrix(source, k_key, read_numbers(source, k_key, k_node, 3, 3));
        tell_of_distortion(source, root);
        return from_pinhole(
            source, k_key,
            {.fx = k.fx, .fy = k.fy, .cx = k.cx, .cy = k.cy, .width = camera.width, .height = camera.height});
    }
    if (p[7] != 0) refuse_key(source, p_key, "is of a vertical pair; only horizontal pairs are read");
    camera.fx = p[0];
    camera.fy = p[5];
    camera.cx = p[2];
    camera.cy = p[6];
    Calibration calibration = from_pinhole(source, p_key, camera);
    if (p[3] != 0) {
        source.has_baseline = true;
        calibration.baseline_m = -p[3] / p[0];
        source.told.push_back(p_key +
                              " is of the right camera; its principal point is taken for the left one's");
    }
    return calibration;
}

std::optional<Calibration> parse_lengths(CalibrationText& source, const YAML::Node& root) {
    if (!root["fx"].IsDefined()) return std::nullopt;
    source.format = root["ppx"].IsDefined() ? "RealSense intrinsics" : "intrinsics";
    const auto number = [&](std::initializer_list<const char*> keys) {
        const auto [key, node] = find_key(root, keys);
        if (key.empty())
            refuse_key(source, *keys.begin(), "is missing; fx, fy, ppx (or cx) and ppy (or cy) go together");
        return number_of(source, key, node);
    };
    Pinhole camera{
        .fx = number({"fx"}), .fy = number({"fy"}), .cx = number({"ppx", "cx"}), .cy = number({"ppy", "cy"})};
    std::tie(camera.width, camera.height) = size_of(source, root);
    tell_of_distortion(source, root);
    return from_pinhole(source, "fx and fy", camera);
}

}  // namespace

std::optional<Calibration> parse_camera_tree(CalibrationText& source, const YAML::Node& root) {
    if (const YAML::Node inner = root["intrinsic"]; inner.IsDefined() && inner.IsMap())
        return parse_camera_tree(source, inner);  // Open3D's PinholeCameraParameters
    if (const auto camera = parse_ros(source, root)) return camera;
    if (const auto camera = parse_lengths(source, root)) return camera;
    const auto [key, node] =
        find_key(root, {"intrinsic_matrix", "K", "camera_matrix", "intrinsics", "intrinsic"});
    if (key.empty()) return std::nullopt;
    source.format = key == "intrinsic_matrix" ? "Open3D intrinsics" : "camera matrix";
    Pinhole camera = from_matrix(source, key, read_numbers(source, key, node, 3, 3));
    std::tie(camera.width, camera.height) = size_of(source, root);
    tell_of_distortion(source, root);
    return from_pinhole(source, key, camera);
}

}  // namespace hexrelief::readers::codec
