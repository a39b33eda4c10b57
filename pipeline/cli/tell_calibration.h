// Calibrations, as `hexrelief info` tells them.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pipeline/data/number_text.h"

namespace hexrelief::cli::info {

using Json = nlohmann::ordered_json;

// One thing that is told of a file: in words, and as JSON has it.
struct Line {
    std::string name, words;
    Json value;
    bool is_of_list = false;
};
using Text = std::vector<Line>;

// Add a line; its words are its value, if no other is given.
void line(Text& text, const std::string& name, const std::string& words);
void line(Text& text, const std::string& name, const std::string& words, Json value);
void count(Text& text, const std::string& name, long long number);
void size_line(Text& text, int width, int height);  // px
// Adds a list of values.
void lines(Text& text, const std::string& name, const std::vector<std::string>& values);

// Returns the lines in words, a list's name before its first value only, or as an object of JSON.
std::string told(const Text& text, bool json);

// Returns up to six digits.
inline std::string number(double value) {
    return number_text(value, 6);
}

// Adds the calibration in a file, of one camera or of a pair to rectify. Throws Error(input).
void tell_calibration_of(const std::filesystem::path& path, Text& text);
// Adds the calibration in a file of arrays; false if the file is no camera, but perhaps a map.
bool tell_if_calibration(const std::filesystem::path& path, Text& text);

}  // namespace hexrelief::cli::info
