// Parses calibrations of plain text: Middlebury's calib.txt and hexrelief's own keys, as people write and
// edit them, KITTI's matrices, numbers alone, and MVSNet's cameras.
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include "pipeline/readers/cameras/calibration_formats.h"
#include "pipeline/readers/cameras/entries.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::readers::codec {
namespace {

using Lines = std::map<std::string, std::string, std::less<>>;

std::string_view before_hash(std::string_view line) {
    return line.substr(0, line.find('#'));
}

bool is_middlebury(std::string_view text) {
    for (std::string_view line : lines(text)) {
        const std::size_t equals = before_hash(line).find('=');
        if (equals == std::string_view::npos) continue;
        const std::string_view key = trim(line.substr(0, equals));
        if (key == "cam0" || key == "baseline" || key == "cam1") return true;
    }
    return false;
}

Lines assignments(const CalibrationText& source) {
    Lines entries;
    for (std::string_view line : lines(source.text)) {
        line = trim(before_hash(line));
        if (line.empty()) continue;
        const std::size_t equals = line.find('=');
        if (equals == std::string_view::npos)
            refuse_key(source, "line " + excerpt(line), "is no key=value; correct or remove it");
        const std::string key(trim(line.substr(0, equals)));
        if (!entries.emplace(key, trim(line.substr(equals + 1))).second)
            refuse_key(source, excerpt(key), "is given twice; keep one");
    }
    return entries;
}

// Returns the words of the text without comments and brackets.
std::vector<std::string> numbers_of(std::string_view text) {
    std::string plain;
    for (const std::string_view line : lines(text)) plain.append(before_hash(line)).append(" ");
    std::ranges::replace_if(
        plain, [](char c) { return std::string_view("[];()").find(c) != std::string_view::npos; }, ' ');
    const std::vector<std::string_view> found = words(plain);
    return {found.begin(), found.end()};
}

struct Camera {
    double focal, cx, cy;
};

// Parses "[f 0 cx; 0 f cy; 0 0 1]".
Camera read_camera(CalibrationText& source, const std::string& key, std::string_view text) {
    const std::vector<std::string> parts = numbers_of(text);
    if (parts.size() != 9)
        refuse_key(source, key,
                   "has " + std::to_string(parts.size()) + " numbers; [f 0 cx; 0 f cy; 0 0 1] is expected");
    double m[9];
    for (std::size_t i = 0; i < 9; ++i) m[i] = require_number(source, key, parts[i]);
    if (m[3] != 0 || m[6] != 0 || m[7] != 0 || m[8] != 1)
        refuse_key(source, key, "is no camera matrix; [f 0 cx; 0 f cy; 0 0 1] is expected");
    return {require_square(source, key, m[0], m[4]), m[2], m[5]};
}

// Returns the camera's number in a key "P2", "P_rect_02" or, as DrivingStereo has it, "P_rect_101"; -1 for
// any other key.
int camera_of(std::string_view key) {
    const bool is_long = key.starts_with("P_rect_");
    const std::string_view digits = is_long ? key.substr(7) : key.starts_with("P") ? key.substr(1) : "";
    const bool are_digits = digits.find_first_not_of("0123456789") == std::string_view::npos;
    if (digits.empty() || !are_digits || digits.size() > (is_long ? 3u : 1u)) return -1;
    const int number = std::stoi(std::string(digits));
    return is_long || number <= 3 ? number : -1;
}

std::string key_of(const char* prefix, int camera) {
    return prefix + std::string(camera < 10 ? "0" : "") + std::to_string(camera);
}

// Returns only the entries of the cameras' matrices and sizes; a file also has rotations,
// times and lidar poses.
Lines read_lines(const CalibrationText& source) {
    Lines entries;
    for (std::string_view line : lines(source.text)) {
        const std::size_t colon = line.find(':');
        if (colon == std::string_view::npos) continue;
        const std::string_view key = trim(line.substr(0, colon)), value = trim(line.substr(colon + 1));
        if (camera_of(key) < 0 && !key.starts_with("S_rect_")) continue;
        if (value.starts_with('!') || value.starts_with('[') || value.empty())
            return {};  // this is YAML with keys of that name
        if (!entries.emplace(key, value).second) refuse_key(source, key, "is given twice; keep one");
    }
    return entries;
}

Projection read_projection(CalibrationText& source, const std::string& key, std::string_view text) {
    const auto parts = words(text);
    if (parts.size() != 12)
        refuse_key(source, key, "has " + std::to_string(parts.size()) + " numbers; a 3x4 matrix has 12");
    Projection p{};
    for (std::size_t i = 0; i < p.size(); ++i) p[i] = require_number(source, key, parts[i]);
    if (!(p[0] > 0)) refuse_key(source, key, "has a focal length that is not above 0");
    p[0] = require_square(source, key, p[0], p[5]);
    return p;
}

Calibration from_pair(CalibrationText& source, const Lines& entries, const std::string& left,
                      const std::string& right) {
    const Projection l = read_projection(source, left, entries.find(left)->second);
    const Projection r = read_projection(source, right, entries.find(right)->second);
    require_one_focal(source, left + " and " + right, l[0], r[0]);
    return from_projections(l, r);
}

void take_size(const CalibrationText& source, const Lines& entries, int camera, Calibration& calibration) {
    const std::string size = key_of("S_rect_", camera);
    const auto found = entries.find(size);
    if (found == entries.end()) return;
    const auto parts = words(found->second);
    if (parts.size() != 2) refuse_key(source, size, "must hold width and height");
    calibration.width = require_side(source, size, require_number(source, size, parts[0]));
    calibration.height = require_side(source, size, require_number(source, size, parts[1]));
}

// Returns the camera of a file with one projection, without a baseline.
Calibration of_one(CalibrationText& source, const Lines& entries) {
    std::string key;
    for (const auto& [name, value] : entries) {
        if (camera_of(name) < 0) continue;
        if (!key.empty())
            refuse_key(
                source, key + " and " + name,
                "are of no pair; a KITTI calibration needs P2 and P3, or P0 and P1, or one of them alone");
        key = name;
    }
    const Projection p = read_projection(source, key, entries.find(key)->second);
    Calibration calibration = from_pinhole(source, key, {.fx = p[0], .fy = p[0], .cx = p[2], .cy = p[6]});
    take_size(source, entries, camera_of(key), calibration);
    return calibration;
}

}  // namespace

std::optional<Calibration> parse_middlebury(CalibrationText& source) {
    if (!is_middlebury(source.text)) return std::nullopt;
    source.format = "Middlebury";
    const Lines entries = assignments(source);
    const auto find = [&](const char* key) {
        const auto found = entries.find(key);
        return found == entries.end() ? nullptr : &found->second;
    };
    const auto require = [&](const char* key) {
        if (const std::string* const text = find(key)) return *text;
        refuse_key(source, key, "is missing; Middlebury's calib.txt must have it");
    };
    const auto take_side = [&](const char* key, int& side) {
        if (const std::string* const text = find(key))
            side = require_side(source, key, require_number(source, key, *text));
    };
    const Camera left = read_camera(source, "cam0", require("cam0"));

    Calibration calibration{.focal_px = left.focal,
                            .cx = left.cx + kPixelCentre,
                            .cy = left.cy + kPixelCentre,
                            .baseline_m = require_number(source, "baseline", require("baseline")) / 1000};
    if (const std::string* const doffs = find("doffs"))
        calibration.doffs_px = require_number(source, "doffs", *doffs);
    else if (const std::string* const right = find("cam1"))
        calibration.doffs_px = read_camera(source, "cam1", *right).cx - left.cx;
    else
        refuse_key(source, "doffs",
                   "is missing, and so is cam1; one of them must be there (doffs=0 where cx is shared)");
    take_side("width", calibration.width);
    take_side("height", calibration.height);
    take_side("ndisp", calibration.ndisp_px);
    return calibration;
}

Calibration own_calibration(CalibrationText& source, const Entries& entries) {
    Calibration calibration;
    const std::map<std::string, double*> lengths = {{"focal_px", &calibration.focal_px},
                                                    {"baseline_m", &calibration.baseline_m},
                                                    {"cx", &calibration.cx},
                                                    {"cy", &calibration.cy},
                                                    {"doffs_px", &calibration.doffs_px}};
    int &width = calibration.width, &height = calibration.height;
    std::set<std::string> seen;
    for (const Entry& entry : entries) {
        const std::string& key = entry.name;
        if (!seen.insert(key).second) refuse_key(source, excerpt(key), "is given twice; keep one");
        const auto number = [&] {
            if (entry.values.size() != 1) refuse_key(source, key, "must be a number");
            return require_number(source, key, entry.values[0]);
        };
        if (const auto length = lengths.find(key); length != lengths.end())
            *length->second = number();
        else if (key == "width" || key == "height")
            (key == "width" ? width : height) = require_side(source, key, number());
        else
            refuse_key(source, excerpt(key),
                       "is not known; the keys are focal_px, baseline_m, cx, cy, doffs_px, width, height");
    }
    source.has_baseline = seen.contains("baseline_m");
    const bool has_cx = seen.contains("cx"), has_cy = seen.contains("cy");
    if (!seen.contains("focal_px"))
        refuse_key(source, "focal_px", "is missing; give the focal length in pixels");
    if ((width == 0) != (height == 0)) refuse_key(source, "width and height", "must be given together");
    if (has_cx != has_cy)
        refuse_key(source, "cx and cy", "must be given together; without both the centre is taken");
    if (!has_cx) {
        calibration.cx = width > 0 ? width / 2.0 : std::nan("");
        calibration.cy = height > 0 ? height / 2.0 : std::nan("");
    }
    return calibration;
}

std::optional<Calibration> parse_kitti(CalibrationText& source) {
    const Lines entries = read_lines(source);
    bool any = false;
    for (const auto& [key, value] : entries) any = any || camera_of(key) >= 0;
    if (!any) return std::nullopt;
    source.format = "KITTI";

    std::vector<std::pair<int, int>> pairs = {{2, 3}, {0, 1}};
    constexpr int kLeastOfDrivingStereo = 100;
    for (const auto& [key, value] : entries)
        if (const int camera = camera_of(key); camera >= kLeastOfDrivingStereo)
            pairs.emplace_back(camera, camera + 2);
    for (const auto& [left, right] : pairs)
        for (const bool is_long : {true, false}) {
            const std::string l = is_long ? key_of("P_rect_", left) : "P" + std::to_string(left),
                              r = is_long ? key_of("P_rect_", right) : "P" + std::to_string(right);
            if (!entries.contains(l) || !entries.contains(r)) continue;
            Calibration calibration = from_pair(source, entries, l, r);
            take_size(source, entries, left, calibration);
            return calibration;
        }
    return of_one(source, entries);
}

std::optional<Calibration> parse_matrix(CalibrationText& source) {
    const std::vector<std::string> parts = numbers_of(source.text);
    if (parts.empty() || !parse_number(parts.front())) return std::nullopt;
    std::vector<double> values;
    for (std::size_t i = 0; i < parts.size(); ++i)
        values.push_back(require_number(source, "number " + std::to_string(i + 1), parts[i]));
    const std::size_t count = values.size();
    source.format = "camera matrix";
    if (count == 4 || count == 6) {
        source.format = "numbers alone";
        const std::size_t at = count - 4;
        Pinhole camera{.fx = values[at], .fy = values[at + 1], .cx = values[at + 2], .cy = values[at + 3]};
        if (count == 6) {
            camera.width = require_side(source, "the width", values[0]);
            camera.height = require_side(source, "the height", values[1]);
        }
        return from_pinhole(source, "fx and fy", camera);
    }
    if (count != 9 && count != 10 && count != 12 && count != 16)
        refuse_key(
            source, "the file",
            "has " + std::to_string(count) +
                " numbers; a 3x3 camera matrix has 9, and a baseline in metres may follow, 3x4 has 12, 4x4 "
                "16, fx fy cx cy 4, w h fx fy cx cy 6");
    const double baseline_m = values.back();
    if (count == 10) values.resize(9);
    Calibration calibration =
        from_pinhole(source, "the matrix", from_matrix(source, "the matrix", upper_left(values)));
    if (count == 10) {
        source.format = "camera matrix and baseline";
        source.has_baseline = true;
        calibration.baseline_m = baseline_m;
    }
    return calibration;
}

std::optional<Calibration> parse_mvsnet(CalibrationText& source) {
    const std::vector<std::string> parts = numbers_of(source.text);
    const auto found = std::ranges::find(parts, "intrinsic");
    if (parts.empty() || parts.front() != "extrinsic" || found == parts.end()) return std::nullopt;
    source.format = "MVSNet";
    if (parts.end() - found < 10) refuse_key(source, "intrinsic", "must be followed by the 9 numbers of K");
    std::vector<double> k;
    for (auto part = found + 1; part != found + 10; ++part)
        k.push_back(require_number(source, "intrinsic", *part));
    return from_pinhole(source, "intrinsic", from_matrix(source, "intrinsic", k));
}

}  // namespace hexrelief::readers::codec
