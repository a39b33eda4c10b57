// The values of a calibration file as a list of names and texts, whatever notation it is written in.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/readers/cameras/calibration_formats.h"

namespace YAML {
class Node;
}

namespace hexrelief::readers::codec {

// The camera of a pair that a value belongs to, if its name says so.
enum class Side { none, left, right };

struct Entry {
    std::string name;                 // as the file writes it, the names that lead to it joined by '.'
    std::vector<std::string> values;  // by rows; a single value is one text
    std::string key = {};             // the name in small letters, without '_', '-', ' ' and the camera
    Side side = Side::none;
};
using Entries = std::vector<Entry>;

// Returns the name in small letters without '_', '-' and ' '.
std::string plain_name(std::string_view name);

// Return the values of a file, or nothing if the text is not in their notation: XML as OpenCV and RealSense
// write it, "name = value" with sections as in ZED's files and MATLAB's, or YAML, which JSON is part of.
Entries xml_entries(const CalibrationText& source);
Entries assigned_entries(const CalibrationText& source);
Entries yaml_entries(const CalibrationText& source);

// Returns the arrays of an NPZ file.
Entries npz_entries(const std::filesystem::path& path);

// Returns the values below a tree's node. Matrices of OpenCV (rows, cols, data) and nested lists of numbers
// become one entry each.
Entries entries_of_tree(const CalibrationText& source, const YAML::Node& root);

// Returns the values of a file in any notation, with keys and sides.
Entries read_entries(const CalibrationText& source);

// Sets the keys and sides of all entries by their names.
void name_sides(Entries& entries);

// Returns the camera of hexrelief's own keys.
Calibration own_calibration(CalibrationText& source, const Entries& entries);

// Returns the numbers of an entry, or refuses what is not a finite number.
std::vector<double> numbers_of(const CalibrationText& source, const Entry& entry);

}  // namespace hexrelief::readers::codec
