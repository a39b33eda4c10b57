#include "pipeline/job/cameras/resolve_calibration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "pipeline/alignment/rectify/rectify.h"
#include "pipeline/checks/pair_statistics.h"
#include "pipeline/data/error.h"
#include "pipeline/readers/cameras/exif_focal.h"
#include "pipeline/stages/disparity_range.h"

namespace hexrelief::job {
namespace {

void override_by(double& value, double given) {
    if (!std::isnan(given)) value = given;
}

// Also stores the origin of the value.
void override_by(double& value, double given, const char* key, std::string& from) {
    if (std::isnan(given)) return;
    value = given;
    from = key;
}

// Returns the distance of the principal point from the middle of a view of this size, as a
// share of its sides.
double off_centre(const Calibration& camera, ViewSize size) {
    return std::hypot(camera.cx / size.width - 0.5, camera.cy / size.height - 0.5);
}

// Shares of a picture's sides.
constexpr double kInTheMiddle = 0.06;  // principal points of whole pictures lie nearer to the middle
constexpr double kOffTheMiddle = 0.2;  // those of another size's lie farther off

// The factors by which pictures are usually scaled, as fractions.
struct Factor {
    int above, below;
};
constexpr Factor kFactors[] = {{4, 3}, {3, 2}, {5, 3}, {2, 1},  {5, 2},  {3, 1}, {4, 1},
                               {5, 1}, {6, 1}, {8, 1}, {10, 1}, {12, 1}, {16, 1}};

// Returns the size of a picture of the view's aspect, larger or smaller by a usual factor, in whose middle
// the principal point lies; the view's if the point may be of the view.
ViewSize size_by_centre(const Calibration& camera, ViewSize view) {
    constexpr int largest_px = 1 << 20;
    if (std::isnan(camera.cx) || off_centre(camera, view) < kOffTheMiddle ||
        std::max(view.width, view.height) > largest_px)
        return view;
    ViewSize nearest = view;
    double least = kInTheMiddle;
    for (const auto& [above, below] : kFactors)
        for (const ViewSize size : {ViewSize{view.width * above / below, view.height * above / below},
                                    ViewSize{view.width * below / above, view.height * below / above}})
            if (size.width > 0 && size.height > 0 && off_centre(camera, size) < least) {
                least = off_centre(camera, size);
                nearest = size;
            }
    return nearest;
}

// Returns the size that the file's camera is for. A file without a size is for the view, or for its picture
// if the principal point is closer to the picture's middle, or for the size in whose middle it is.
ViewSize believed_size(const Calibration& camera, const CameraSource& source) {
    if (camera.width > 0) return {camera.width, camera.height};
    const bool of_picture =
        !std::isnan(camera.cx) && off_centre(camera, source.picture) < off_centre(camera, source.view);
    return of_picture ? source.picture : size_by_centre(camera, source.view);
}

// Returns the file's camera, scaled to the view.
Calibration camera_of_file(const CameraSource& source, ResolvedCalibration& resolved) {
    const readers::CalibrationFile file = readers::read_calibration_file(
        calibration_files(source.config, source.view, {source.view_file, source.picture_file}));
    for (const std::string& told : file.told) resolved.warnings.push_back(source.config.file + ": " + told);
    resolved.focal_from = resolved.baseline_from = "the calibration file (" + file.format + ")";
    resolved.other_file = file.other;
    Calibration camera = file.calibration;
    const bool centre_is_given = !std::isnan(source.config.cx) && !std::isnan(source.config.cy);
    const bool size_is_said = camera.width > 0;
    const ViewSize size = centre_is_given && !size_is_said ? source.view : believed_size(camera, source);
    const bool fits = same_aspect(size, source.view);
    if (!fits && size != source.picture)
        throw Error(ErrorKind::input, source.config.file + ": the calibration is for " + size_text(size) +
                                          " px, but the image has " + size_text(source.view) +
                                          " px, of another aspect; use the calibration of that size");
    if (std::isnan(camera.cx)) camera.cx = 0.5 * size.width;
    if (std::isnan(camera.cy)) camera.cy = 0.5 * size.height;
    if (size == source.view) {
        if (!size_is_said && !centre_is_given && off_centre(camera, size) >= kOffTheMiddle)
            resolved.warnings.push_back(source.config.file + ": its principal point (" +
                                        number_text(camera.cx) + ", " + number_text(camera.cy) +
                                        ") lies far off the middle of " + size_text(size) +
                                        " px; if the camera is for another size, scale it");
        return camera;
    }
    if (size == source.picture)
        resolved.decisions.push_back("calibration: of the picture's " + size_text(size) +
                                     " px, scaled to the map's " + size_text(source.view));
    else if (size_is_said)
        resolved.decisions.push_back("calibration: for " + size_text(size) + " px, scaled to the view's " +
                                     size_text(source.view));
    else
        resolved.warnings.push_back(source.config.file + ": its principal point lies in the middle of " +
                                    size_text(size) + " px, so the camera is scaled to the picture's " +
                                    size_text(source.view) +
                                    "; if it is for this size, give input.calibration.cx and cy as well");
    camera.width = size.width;
    camera.height = size.height;
    return scaled_to(camera, source.view);
}

// Returns the focal length from the picture's EXIF data, in px of the view; 0 = unknown.
double focal_of_picture(const CameraSource& source, ResolvedCalibration& resolved) {
    if (source.picture_file.empty()) return 0;
    const auto focal =
        readers::read_exif_focal(source.picture_file, source.picture.width, source.picture.height);
    if (!focal) return 0;
    const double focal_px = focal->focal_px * source.view.width / source.picture.width;
    resolved.focal_from = "EXIF: " + focal->believed;
    resolved.focal_doubt = "no focal length is given: " + fixed(focal_px, 1) +
                           " px follow from the EXIF data of " + source.picture_file.string() + " (" +
                           focal->believed + "), which is wrong where the picture was cropped";
    return focal_px;
}

void check_principal_point(const Calibration& camera, ViewSize view) {
    if (camera.cx >= -view.width && camera.cx <= 2.0 * view.width && camera.cy >= -view.height &&
        camera.cy <= 2.0 * view.height)
        return;
    throw Error(ErrorKind::input, "the principal point (" + number_text(camera.cx) + ", " +
                                      number_text(camera.cy) + ") lies far outside the image of " +
                                      size_text(view) + " px; is the calibration made for another size?");
}

void check_between(const char* what, double value, double least, double most, const char* unit) {
    if (value >= least && value <= most) return;
    throw Error(ErrorKind::input, std::string("the ") + what + " is " + number_text(value, 6) + " " + unit +
                                      "; it must be from " + number_text(least) + " to " + number_text(most) +
                                      " " + unit + ": check the calibration");
}

// The limits include microscopes and aerial photographs; beyond them depths do not fit into floats.
void check_camera_range(const Calibration& camera) {
    check_between("focal length", camera.focal_px, 1e-3, 1e9, "px");
    check_between("baseline", camera.baseline_m, 1e-12, 1e9, "m");
    check_between("difference of the principal points (doffs)", camera.doffs_px, -1e6, 1e6, "px");
}

constexpr int kLeastPoints = 12;        // that agree on the rows
constexpr double kLeastAgreeing = 0.5;  // share of the points
constexpr double kOff_px = 1;           // rows of rectified pictures are off by less
constexpr double kRemaining = 0.6;      // rectification leaves less of an offset that it explains

// Returns the cameras for pictures of this size; the file is for the message.
StereoCalibration scaled_to(StereoCalibration cameras, ViewSize size, const std::string& file) {
    const ViewSize made_for{cameras.width, cameras.height};
    if (made_for.width == 0 || made_for == size) return cameras;
    if (!same_aspect(made_for, size))
        throw Error(ErrorKind::input, file + ": the calibration is for " + size_text(made_for) +
                                          " px, but the pictures have " + size_text(size) +
                                          " px, of another aspect; use the calibration of that size");
    const double x = 1.0 * size.width / made_for.width, y = 1.0 * size.height / made_for.height;
    for (auto* const camera : {&cameras.left, &cameras.right}) {
        std::array<double, 9>& k = camera->matrix;
        k[0] *= x;
        k[2] = (k[2] + 0.5) * x - 0.5;  // from the corner, which scaling leaves in place
        k[4] *= y;
        k[5] = (k[5] + 0.5) * y - 0.5;
    }
    cameras.width = size.width;
    cameras.height = size.height;
    return cameras;
}

// Returns how far the rows are off at a corner of the picture, in px; NaN if the points do not tell.
double row_offset(const StereoPair& pair, int threads) {
    const stages::SmallMatch coarse = stages::match_coarsely(pair, 0, threads);
    const auto is_sure = [](const checks::RowFit& fit) {
        return fit.points >= kLeastPoints && fit.agreeing_share >= kLeastAgreeing;
    };
    // Points near the coarse match's disparities are the exact ones, if the rows are near enough to have any.
    if (const checks::RowFit fit = checks::measure_rows(pair, coarse, threads); is_sure(fit))
        return fit.largest_px;
    const checks::RowFit fit = checks::match_coarse_points(coarse, threads).rows;
    return is_sure(fit) ? fit.largest_px : std::numeric_limits<double>::quiet_NaN();
}

// True if the pair's rows are off, and those of its rectified views are less so or unknown.
bool is_as_taken(const StereoPair& views, const StereoPair& rectified, int threads) {
    constexpr int least_columns = 16;
    if (views.left.width < least_columns) return false;
    const double before_px = row_offset(views, threads);
    if (!(before_px > kOff_px)) return false;
    const double after_px = row_offset(rectified, threads);
    return std::isnan(after_px) || after_px < kRemaining * before_px;
}

}  // namespace

std::string size_text(ViewSize size) {
    return size_text(size.width, size.height);
}

bool same_aspect(ViewSize a, ViewSize b) {
    if (a.width > b.width) std::swap(a, b);
    const double width = 1.0 * a.height * b.width / b.height, height = 1.0 * a.width * b.height / b.width;
    return std::abs(width - a.width) <= 1 || std::abs(height - a.height) <= 1;
}

std::string camera_text(const Calibration& camera, const std::string& focal_from,
                        const std::string& baseline_from) {
    return "focal " + fixed(camera.focal_px, 2) + " px, baseline " + fixed(camera.baseline_m, 4) +
           (camera.metric ? " m" : " (relative)") + ", principal point (" + fixed(camera.cx, 2) + ", " +
           fixed(camera.cy, 2) + "), doffs " + fixed(camera.doffs_px, 2) + " px; focal: " + focal_from +
           ", baseline: " + baseline_from;
}

Calibration scaled_to(const Calibration& camera, ViewSize size) {
    // Image points are measured from the corner, so they scale without the half pixel of other conventions.
    const double x = 1.0 * size.width / camera.width, y = 1.0 * size.height / camera.height;
    Calibration scaled = camera;
    scaled.focal_px *= x;
    scaled.cx *= x;
    scaled.cy *= y;
    scaled.doffs_px *= x;
    scaled.ndisp_px = static_cast<int>(std::ceil(camera.ndisp_px * x));
    scaled.width = size.width;
    scaled.height = size.height;
    return scaled;
}

readers::CalibrationSource calibration_files(const config::CalibrationConfig& config, ViewSize size,
                                             std::vector<std::filesystem::path> views) {
    return {config.file, config.second_file, size.width, size.height, std::move(views)};
}

double said_per_m(const config::InputConfig& config, const std::filesystem::path& map) {
    if (config.calibration.file.empty()) return 0;
    try {
        return readers::read_calibration_file(calibration_files(config.calibration, {}, {map})).depth_per_m;
    } catch (const Error&) {
        return 0;  // told when the camera is read, for which the map's size may be needed
    }
}

ResolvedCalibration resolve_calibration(const CameraSource& source) {
    const config::CalibrationConfig& config = source.config;
    const ViewSize view = source.view;
    ResolvedCalibration resolved;
    Calibration& camera = resolved.calibration;
    camera.cx = 0.5 * view.width;
    camera.cy = 0.5 * view.height;
    if (source.rectified) {
        camera = *source.rectified;
        resolved.focal_from = resolved.baseline_from = "the calibration file, rectified";
    } else if (!config.file.empty()) {
        camera = camera_of_file(source, resolved);
    } else if (source.container) {
        camera = *source.container;
        resolved.focal_from = resolved.baseline_from = kOwnCamera;
    }
    override_by(camera.focal_px, config.focal_px, "input.calibration.focal_px", resolved.focal_from);
    override_by(camera.focal_px, 0.5 * view.width / std::tan(config.fov_x_deg * std::acos(-1.0) / 360),
                "input.calibration.fov_x_deg", resolved.focal_from);
    override_by(camera.baseline_m, config.baseline_m, "input.calibration.baseline_m", resolved.baseline_from);
    override_by(camera.cx, config.cx);
    override_by(camera.cy, config.cy);
    override_by(camera.doffs_px, config.doffs_px);
    if (!(camera.focal_px > 0)) camera.focal_px = focal_of_picture(source, resolved);
    resolved.is_focal_known = camera.focal_px > 0;
    resolved.is_baseline_known = camera.baseline_m > 0;
    if (!resolved.is_focal_known) {
        camera.focal_px = view.width;
        resolved.focal_from = "not known, the picture's width is taken";
    }
    if (!resolved.is_baseline_known) {
        camera.baseline_m = 1;
        resolved.baseline_from = "not known, 1 is taken";
    }
    camera.metric = resolved.is_focal_known && resolved.is_baseline_known;
    camera.width = view.width;
    camera.height = view.height;
    check_principal_point(camera, view);
    check_camera_range(camera);
    return resolved;
}

std::string missing_for_metres(const ResolvedCalibration& resolved) {
    if (resolved.calibration.metric) return {};
    if (resolved.is_focal_known)
        return "the cameras' baseline is not known: the mesh is in relative units; give "
               "input.calibration.baseline_m, or the right camera's file by a second --calib";
    if (resolved.is_baseline_known)
        return "the focal length is not known: the mesh is in relative units; give --fov-x DEG or "
               "input.calibration.focal_px";
    return "no calibration: the focal length is guessed as the picture's width and the mesh is in relative "
           "units; give --calib FILE";
}

FileRectification rectify_by_file(StereoPair& views, const config::InputConfig& input, int threads) {
    const config::CalibrationConfig& config = input.calibration;
    if (config.file.empty()) {
        if (config.rectify == readers::Rectify::always)
            throw Error(ErrorKind::usage, "input.calibration.rectify needs a calibration file (--calib)");
        return {};
    }
    const bool never = input.rectify == config::PairRectification::never;
    if (never && config.rectify == readers::Rectify::always)
        throw Error(ErrorKind::usage, "input.rectify never contradicts input.calibration.rectify always");
    const ViewSize size{views.left.width, views.left.height};
    const auto file = readers::read_stereo_calibration(calibration_files(config, size),
                                                       never ? readers::Rectify::never : config.rectify);
    if (!file) return {};
    const StereoCalibration cameras = scaled_to(file->calibration, size, config.file);
    alignment::RectifiedPair rectified = alignment::rectify(views, cameras, threads);
    FileRectification done;
    const std::string files = config.file + (file->other.empty() ? "" : " and " + file->other.string());
    if (file->is_rectified && config.rectify == readers::Rectify::automatic) {
        if (!is_as_taken(views, rectified.pair, threads)) {
            done.decisions.push_back("not rectified: " + files +
                                     " tells of rectified pictures as well, and the rows are not off");
            return done;
        }
        done.warnings.push_back(
            files +
            " tells of pictures as they were taken and of rectified ones; by its points the pair "
            "is of the former, so it is rectified (input.calibration.rectify=never leaves it)");
    }
    for (const std::string& told : file->told) done.warnings.push_back(config.file + ": " + told);
    if (const Image alpha{size.width, size.height, 1, views.left.alpha}; !alpha.empty())
        rectified.pair.left.alpha = alignment::rectify({alpha, alpha}, cameras, threads).pair.left.pixels;
    views = std::move(rectified.pair);
    done.is_done = true;
    done.calibration = rectified.calibration;
    done.seen = std::move(rectified.seen);
    done.other_file = file->other;
    if (cameras.width == 0 || (file->calibration.width == cameras.width))
        done.decisions.push_back(
            "rectified: by " + std::string(cameras.is_fisheye ? "a fisheye model" : "K1, D1, K2, D2, R, T") +
            " of " + files + " (" + file->format + ")");
    else
        done.decisions.push_back("rectified: by " + files + " (" + file->format + "), scaled from " +
                                 size_text({file->calibration.width, file->calibration.height}) + " px");
    return done;
}

}  // namespace hexrelief::job
