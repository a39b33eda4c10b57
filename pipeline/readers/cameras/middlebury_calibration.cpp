// Parses Middlebury's calib.txt, "key=value" lines as people write and edit them.

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
        if (equals == std::string_view::npos) {
            refuse_key(source, "line " + excerpt(line), "is no key=value; correct or remove it");
        }
        const std::string key(trim(line.substr(0, equals)));
        if (!entries.emplace(key, trim(line.substr(equals + 1))).second) {
            refuse_key(source, excerpt(key), "is given twice; keep one");
        }
    }
    return entries;
}

struct Camera {
    double focal, cx, cy;
};

// Parses "[f 0 cx; 0 f cy; 0 0 1]".
Camera read_camera(CalibrationText& source, const std::string& key, std::string_view text) {
    std::string plain(text);
    for (char& c : plain) {
        if (c == '[' || c == ']' || c == ';') c = ' ';
    }
    const auto parts = words(plain);
    if (parts.size() != 9) {
        refuse_key(source, key,
                   "has " + std::to_string(parts.size()) + " numbers; [f 0 cx; 0 f cy; 0 0 1] is expected");
    }
    double m[9];
    for (std::size_t i = 0; i < 9; ++i) m[i] = require_number(source, key, parts[i]);
    if (m[3] != 0 || m[6] != 0 || m[7] != 0 || m[8] != 1) {
        refuse_key(source, key, "is no camera matrix; [f 0 cx; 0 f cy; 0 0 1] is expected");
    }
    return {require_square(source, key, m[0], m[4]), m[2], m[5]};
}

}  // namespace

std::optional<Calibration> parse_middlebury(CalibrationText& source) {
    if (!is_middlebury(source.text)) return std::nullopt;
    source.format = "Middlebury";
    const Lines entries = assignments(source);
    const auto require = [&](const char* key) -> const std::string& {
        const auto found = entries.find(key);
        if (found == entries.end())
            refuse_key(source, key, "is missing; Middlebury's calib.txt must have it");
        return found->second;
    };
    const Camera left = read_camera(source, "cam0", require("cam0"));

    Calibration calibration;
    calibration.focal_px = left.focal;
    calibration.cx = left.cx + kPixelCentre;
    calibration.cy = left.cy + kPixelCentre;
    calibration.baseline_m = require_number(source, "baseline", require("baseline")) / 1000;
    if (const auto doffs = entries.find("doffs"); doffs != entries.end()) {
        calibration.doffs_px = require_number(source, "doffs", doffs->second);
    } else if (const auto right = entries.find("cam1"); right != entries.end()) {
        calibration.doffs_px = read_camera(source, "cam1", right->second).cx - left.cx;
    } else {
        refuse_key(source, "doffs",
                   "is missing, and so is cam1; one of them must be there (doffs=0 where cx is shared)");
    }
    for (const auto& [key, side] :
         {std::pair{"width", &calibration.width}, {"height", &calibration.height}}) {
        const auto found = entries.find(key);
        if (found != entries.end())
            *side = require_side(source, key, require_number(source, key, found->second));
    }
    if (const auto ndisp = entries.find("ndisp"); ndisp != entries.end())
        calibration.ndisp_px = require_side(source, "ndisp", require_number(source, "ndisp", ndisp->second));
    return calibration;
}

Calibration own_calibration(CalibrationText& source, const Entries& entries) {
    Calibration calibration;
    const std::map<std::string, double*> lengths = {{"focal_px", &calibration.focal_px},
                                                    {"baseline_m", &calibration.baseline_m},
                                                    {"cx", &calibration.cx},
                                                    {"cy", &calibration.cy},
                                                    {"doffs_px", &calibration.doffs_px}};
    int width = 0, height = 0;
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
    calibration.width = width;
    calibration.height = height;
    return calibration;
}

}  // namespace hexrelief::readers::codec
