#include "pipeline/cli/tell_calibration.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pipeline/cli/printable.h"
#include "pipeline/data/error.h"
#include "pipeline/readers/cameras/calibration_reader.h"

namespace hexrelief::cli::info {
namespace {

void tell_calibration(const readers::CalibrationFile& file, Text& text) {
    const Calibration& camera = file.calibration;
    line(text, "format", "calibration, " + file.format);
    line(text, "focal", number(camera.focal_px) + " px", camera.focal_px);
    if (camera.baseline_m > 0)
        line(text, "baseline", number(camera.baseline_m) + " m", camera.baseline_m);
    else
        line(text, "baseline", "not known", nullptr);
    line(text, "centre",
         std::isnan(camera.cx) ? "not said: the middle"
                               : "(" + number(camera.cx) + ", " + number(camera.cy) +
                                     ") px, the first pixel's centre is (0.5, 0.5)",
         std::isnan(camera.cx) ? Json() : Json({camera.cx, camera.cy}));
    line(text, "doffs", number(camera.doffs_px) + " px", camera.doffs_px);
    if (camera.width > 0) size_line(text, camera.width, camera.height);
    if (file.depth_per_m > 0) line(text, "depths", number(file.depth_per_m) + " integers in a metre");
    if (!file.other.empty()) line(text, "also", file.other.string());
    lines(text, "note", file.told);
}

void tell_stereo_calibration(const readers::StereoCalibrationFile& file, Text& text) {
    const StereoCalibration& cameras = file.calibration;
    line(text, "format",
         "calibration, " + file.format + ", of a pair to rectify" + (cameras.is_fisheye ? ", fisheye" : ""));
    for (const auto& [name, camera] : {std::pair{"left", cameras.left}, {"right", cameras.right}})
        line(text, name,
             "focal " + number(camera.matrix[0]) + " and " + number(camera.matrix[4]) + " px, " +
                 std::to_string(camera.distortion.size()) + " numbers of distortion");
    const auto& t = cameras.translation;
    const double baseline_m = std::hypot(t[0], t[1], t[2]);
    line(text, "baseline", number(baseline_m) + " m", baseline_m);
    if (cameras.width > 0) size_line(text, cameras.width, cameras.height);
    if (!file.other.empty()) line(text, "also", file.other.string());
    lines(text, "note", file.told);
}

}  // namespace

void line(Text& text, const std::string& name, const std::string& words) {
    text.push_back({name, words, words});
}
void line(Text& text, const std::string& name, const std::string& words, Json value) {
    text.push_back({name, words, std::move(value)});
}
void count(Text& text, const std::string& name, long long number) {
    line(text, name, std::to_string(number), number);
}

void size_line(Text& text, int width, int height) {
    line(text, "size", size_text(width, height, " x ") + " px", {{"width", width}, {"height", height}});
}

void lines(Text& text, const std::string& name, const std::vector<std::string>& values) {
    for (const std::string& value : values) text.push_back({name, value, value, true});
}

std::string told(const Text& text, bool json) {
    std::string words, above;
    Json object = Json::object();
    for (const auto& [name, value_words, value, is_of_list] : text) {
        std::string label = is_of_list && name == above ? "" : name, key = name;
        label.resize(std::max<std::size_t>(label.size(), 14), ' ');
        words += label + printable(value_words) + "\n";
        std::ranges::replace(key, ' ', '_');
        if (is_of_list)
            object[key].push_back(value);
        else
            object[key] = value;
        above = name;
    }
    return json ? object.dump(2, ' ', false, Json::error_handler_t::replace) + "\n" : words;
}

void tell_calibration_of(const std::filesystem::path& path, Text& text) {
    const auto stereo = readers::read_stereo_calibration(path, readers::Rectify::automatic);
    if (stereo && !stereo->is_rectified)
        tell_stereo_calibration(*stereo, text);
    else
        tell_calibration(readers::read_calibration_file(path), text);
}

bool tell_if_calibration(const std::filesystem::path& path, Text& text) {
    try {
        tell_calibration_of(path, text);
    } catch (const Error&) {
        return false;
    }
    return true;
}

}  // namespace hexrelief::cli::info
