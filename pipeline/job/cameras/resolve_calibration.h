// The calibration in effect: from a file, from explicit values, or assumed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/config/config.h"
#include "pipeline/data/calibration.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/number_text.h"
#include "pipeline/readers/cameras/calibration_reader.h"

namespace hexrelief::job {

struct ViewSize {
    int width = 0, height = 0;

    bool operator==(const ViewSize&) const = default;
};

// Returns "640x480".
using hexrelief::size_text;
std::string size_text(ViewSize size);

// True if two sizes have the same aspect: the larger one, scaled to the smaller one's height or width,
// differs from it by at most one pixel.
bool same_aspect(ViewSize a, ViewSize b);

// Returns the camera of the same view at another size of the same aspect.
Calibration scaled_to(const Calibration& camera, ViewSize size);

// The origin of what a photograph's file says of its camera by itself.
inline constexpr const char* kOwnCamera = "the photograph's own camera";

// Returns a camera as text, with the origins of its focal length and baseline.
std::string camera_text(const Calibration& camera, const std::string& focal_from,
                        const std::string& baseline_from);

// Inputs from which a run's camera is found.
struct CameraSource {
    const config::CalibrationConfig& config;
    ViewSize view;                            // size of the map, or of the pair's pictures
    ViewSize picture;                         // size of the left picture; equal to view without a picture
    const Calibration* rectified = nullptr;   // camera of a rectified pair, instead of the file's
    std::filesystem::path picture_file = {};  // file whose EXIF data may give the focal length; empty = none
    const Calibration* container = nullptr;   // camera that the pair's file says, used without a calibration
    std::filesystem::path view_file = {};     // of the map or the left picture; empty = none
};

struct ResolvedCalibration {
    // For the view's size. A missing focal length is the view's width, a missing baseline is 1, a missing
    // principal point is the middle. Metric if focal length and baseline are known.
    Calibration calibration;
    bool is_focal_known = false, is_baseline_known = false;
    // Their origins: a key, "the calibration file (KITTI)", "EXIF: 28 mm on 35 mm film", "the photograph's
    // own camera", or the assumption made instead.
    std::string focal_from, baseline_from;
    std::vector<std::string> warnings, decisions;
    std::string focal_doubt = {};           // a warning of a focal length that EXIF data say; empty = none
    std::filesystem::path other_file = {};  // the second calibration file that was read; empty = none
};

// Returns the files of the configuration, for pictures of this size, of these files.
readers::CalibrationSource calibration_files(const config::CalibrationConfig& config, ViewSize size,
                                             std::vector<std::filesystem::path> views = {});

// Returns how many integers of this depth map are a metre, as the calibration file says; 0 = not said, or the
// file cannot be read.
double said_per_m(const config::InputConfig& config, const std::filesystem::path& map);

// Finds the calibration for the view. Explicit values override the file's and apply to the view. A file's
// camera for another size of the same aspect is scaled to the view's. A camera without a size whose principal
// point lies in the middle of a picture that is larger or smaller by a usual factor, but far off that of the
// view, is taken for that picture's, with a warning, unless the principal point is given. Without a focal
// length, that of the picture's EXIF data is used, with a warning. Throws Error(input) if the file is for a
// size of another aspect, if the principal point lies more than one view's size outside the view, or if focal
// length, baseline or doffs are beyond those of any camera.
ResolvedCalibration resolve_calibration(const CameraSource& source);

// Returns a warning that says what a pair or a disparity map lacks for a mesh in metres; empty = nothing.
std::string missing_for_metres(const ResolvedCalibration& resolved);

struct FileRectification {
    bool is_done = false;  // false: the pair is left as it is
    Calibration calibration = {};
    std::vector<std::uint8_t> seen = {};    // as in RectifiedPair
    std::filesystem::path other_file = {};  // the second calibration file that was read; empty = none
    std::vector<std::string> warnings = {}, decisions = {};
};

// Replaces the views by the rectified ones if the configuration's file tells of the cameras as they took the
// pictures. If it tells of rectified pictures as well, the rows of the pair decide which of both it is.
// Throws Error(input) if the file is for a size of another aspect, and what reading it and rectify() throw.
FileRectification rectify_by_file(StereoPair& views, const config::InputConfig& config, int threads);

}  // namespace hexrelief::job
