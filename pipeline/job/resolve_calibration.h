// The calibration in effect: a file's, explicit values, or none.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/config/config.h"
#include "pipeline/data/calibration.h"

namespace hexrelief::job {

struct ViewSize {
    int width = 0, height = 0;

    bool operator==(const ViewSize&) const = default;
};

// "640x480"
std::string size_text(ViewSize size);

// The same view at two sizes: each side of the smaller follows from the larger's to within a pixel.
bool same_aspect(ViewSize a, ViewSize b);

// The camera of the same view at another size, which has an aspect as `size`.
Calibration scaled_to(const Calibration& camera, ViewSize size);

// What a run is given to find its camera.
struct CameraSource {
    const config::CalibrationConfig& config;
    ViewSize view;                            // of the map, or of the pair's pictures
    ViewSize picture;                         // of the left picture; as the view where there is none
    const Calibration* rectified = nullptr;   // of the pair that was rectified, in place of the file's
    std::filesystem::path picture_file = {};  // whose EXIF data may tell the focal length; empty = none
};

struct ResolvedCalibration {
    // Of the view. Without a focal length it is the view's width, without a baseline that is 1, without a
    // principal point that is in the middle; metric where focal length and baseline are known.
    Calibration calibration;
    bool is_focal_known = false, is_baseline_known = false;
    // Where they come from: a key, "the calibration file (KITTI)", "EXIF: 28 mm on 35 mm film", or what is
    // taken in their stead.
    std::string focal_from, baseline_from;
    std::vector<std::string> warnings, decisions;
};

// Explicit values override the file's; they are of the view. A file's camera of the picture's size is scaled
// to the view's. Where no focal length is given, that of the picture's EXIF data is taken, with a warning.
// Throws Error(input) where the file's is made for yet another size, the principal
// point lies more than one view's size outside of it, or focal length, baseline or doffs are beyond those of
// any camera.
ResolvedCalibration resolve_calibration(const CameraSource& source);

// What is missing for a mesh in metres, as a warning; empty where nothing is. Of a pair or a disparity map.
std::string missing_for_metres(const ResolvedCalibration& resolved);

}  // namespace hexrelief::job
