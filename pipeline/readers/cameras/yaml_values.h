// Values out of YAML and JSON trees, each a refusal where it is not what it must be.
#pragma once

#include <yaml-cpp/yaml.h>

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/readers/cameras/calibration_formats.h"

namespace hexrelief::readers::codec {

// Gives `read` the text as a tree; a refusal that names the line where it is no YAML.
void with_yaml_tree(const CalibrationText& source, const std::function<void(const YAML::Node&)>& read);

double number_of(const CalibrationText& source, const std::string& key, const YAML::Node& node);

// An !!opencv-matrix (rows, cols, dt, data), row-major.
std::vector<double> read_matrix(const CalibrationText& source, const std::string& key, const YAML::Node& node,
                                int rows, int columns);

// As read_matrix(), or the numbers alone, or lists of each row's numbers.
std::vector<double> read_numbers(const CalibrationText& source, const std::string& key,
                                 const YAML::Node& node, int rows, int columns);

// Width and height under one of the names that OpenCV's programs give them; 0, 0 where there is none.
std::pair<int, int> size_of(const CalibrationText& source, const YAML::Node& root);

// One camera: ROS camera_info, Open3D's or RealSense's JSON, or a matrix under a known key. nullopt where the
// tree, which is a map, has none of their keys.
std::optional<Calibration> parse_camera_tree(CalibrationText& source, const YAML::Node& root);

}  // namespace hexrelief::readers::codec
