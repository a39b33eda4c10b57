// Reads hexrelief's own keys.
#include <algorithm>
#include <cmath>

#include "pipeline/readers/cameras/entries.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::readers::codec {

Calibration own_calibration(CalibrationText& source, const Entries& entries) {
    Calibration calibration;
    int width = 0, height = 0;
    bool has_cx = false, has_cy = false, has_focal = false;
    source.has_baseline = false;
    std::vector<std::string> seen;
    for (const Entry& entry : entries) {
        const std::string& key = entry.name;
        if (std::find(seen.begin(), seen.end(), key) != seen.end()) {
            refuse_key(source, excerpt(key), "is given twice; keep one");
        }
        seen.push_back(key);
        const auto number = [&] {
            if (entry.values.size() != 1) refuse_key(source, key, "must be a number");
            return require_number(source, key, entry.values[0]);
        };
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

}  // namespace hexrelief::readers::codec
