#include "pipeline/job/resolve_calibration.h"

#include <cmath>

#include "pipeline/data/error.h"
#include "pipeline/readers/calibration_reader.h"

namespace hexrelief {
namespace {

std::string size_text(int width, int height) {
    return std::to_string(width) + "x" + std::to_string(height);
}

void override_by(double& value, double given) {
    if (!std::isnan(given)) value = given;
}

}  // namespace

Calibration resolve_calibration(const CalibrationConfig& config, int width, int height,
                                std::vector<std::string>& warnings) {
    Calibration camera;
    camera.cx = 0.5 * width;
    camera.cy = 0.5 * height;
    const bool explicit_lengths = !std::isnan(config.focal_px) && !std::isnan(config.baseline_m);
    if (!config.file.empty()) {
        camera = read_calibration(config.file);
        if ((camera.width > 0 && camera.width != width) || (camera.height > 0 && camera.height != height))
            throw Error(ErrorKind::input, config.file + ": the calibration is for " +
                                              size_text(camera.width, camera.height) +
                                              " px, but the image has " + size_text(width, height) +
                                              " px; use the calibration of that size");
        camera.metric = true;
    } else if (explicit_lengths) {
        camera.metric = true;
    } else {
        camera.focal_px = width;
        camera.baseline_m = 1;
        warnings.push_back(
            "no calibration: the mesh is in relative units; give --calib FILE, or input.calibration.focal_px "
            "and baseline_m");
    }
    override_by(camera.focal_px, config.focal_px);
    override_by(camera.baseline_m, config.baseline_m);
    override_by(camera.cx, config.cx);
    override_by(camera.cy, config.cy);
    override_by(camera.doffs_px, config.doffs_px);
    camera.width = width;
    camera.height = height;
    if (camera.cx < -width || camera.cx > 2.0 * width || camera.cy < -height || camera.cy > 2.0 * height)
        throw Error(ErrorKind::input, "the principal point (" + std::to_string(camera.cx) + ", " +
                                          std::to_string(camera.cy) + ") lies far outside the image of " +
                                          size_text(width, height) +
                                          " px; is the calibration made for another size?");
    return camera;
}

}  // namespace hexrelief
