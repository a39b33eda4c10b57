// The rectified stereo camera: what turns a disparity into a depth.
#pragma once

namespace hexrelief {

// Z = focal_px * baseline_m / (disparity + doffs_px). Image x to the right, y down, from the image's top left
// corner: the centre of the top left pixel is (0.5, 0.5), and the principal point is measured alike. metric
// is false where nothing was calibrated: shapes are then right only up to scale and perspective.
struct Calibration {
    double focal_px = 0;
    double cx = 0;
    double cy = 0;
    double baseline_m = 0;
    double doffs_px = 0;
    bool metric = false;
    int width = 0;  // image size that the calibration was made for, 0 = not said
    int height = 0;
    int ndisp_px = 0;  // all disparities of the scene lie below, 0 = not said
};

}  // namespace hexrelief
