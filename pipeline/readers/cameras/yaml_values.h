// Gets values out of YAML and JSON trees; values of the wrong kind are refused.
#pragma once

#include <yaml-cpp/yaml.h>

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/readers/cameras/calibration_formats.h"

namespace hexrelief::readers::codec {

// Calls `read` with the text as a tree. Refuses text that is not YAML, naming the line.
void with_yaml_tree(const CalibrationText& source, const std::function<void(const YAML::Node&)>& read);

// Returns a number, or refuses.
double number_of(const CalibrationText& source, const std::string& key, const YAML::Node& node);

// Returns the numbers of an !!opencv-matrix (rows, cols, dt, data), row-major.
std::vector<double> read_matrix(const CalibrationText& source, const std::string& key, const YAML::Node& node,
                                int rows, int columns);

// Returns the numbers of an !!opencv-matrix, of a plain list, or of lists of each row's numbers.
std::vector<double> read_numbers(const CalibrationText& source, const std::string& key,
                                 const YAML::Node& node, int rows, int columns);

// Returns width and height, from one of the names that OpenCV's programs give them; 0, 0 if there is none.
std::pair<int, int> size_of(const CalibrationText& source, const YAML::Node& root);

// Parses one camera: ROS camera_info, Open3D's or RealSense's JSON, or a matrix under a known key. Returns
// nullopt if the tree, which must be a map, has none of their keys.
std::optional<Calibration> parse_camera_tree(CalibrationText& source, const YAML::Node& root);

}  // namespace hexrelief::readers::codec
