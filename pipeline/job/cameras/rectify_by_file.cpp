#include "pipeline/job/cameras/rectify_by_file.h"

#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "pipeline/alignment/rectify/rectify.h"
#include "pipeline/checks/pair_statistics.h"
#include "pipeline/data/error.h"
#include "pipeline/job/cameras/resolve_calibration.h"
#include "pipeline/readers/cameras/stereo_calibration_reader.h"
#include "pipeline/stages/disparity_range.h"

namespace hexrelief::job {
namespace {

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
    if (const checks::RowFit fit = checks::measure_rows(pair, coarse); is_sure(fit)) return fit.largest_px;
    const checks::RowFit fit = checks::match_coarse_points(coarse).rows;
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
