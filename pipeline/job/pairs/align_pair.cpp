#include "pipeline/job/pairs/align_pair.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "pipeline/alignment/resample.h"
#include "pipeline/checks/pair_statistics.h"
#include "pipeline/data/error.h"
#include "pipeline/data/number_text.h"
#include "pipeline/data/start_work.h"
#include "pipeline/job/pairs/working_size.h"

namespace hexrelief::job {
namespace {

using alignment::Alignment;
using alignment::DisparityBounds;
using alignment::Order;
using alignment::Verdict;

// Added to the range of the matches, which lie between the nearest and the farthest surface: shares of it.
constexpr double kFarMargin = 0.08, kNearMargin = 0.25;
constexpr double kFarMargin_px = 2, kNearMargin_px = 1;
constexpr double kMostBehind = 3;  // of a pair in two files: farther behind infinity than before it

void tell_infinity(PairAlignment& pair) {
    const DisparityBounds& bounds = pair.found.disparities;
    if (bounds.is_infinity_known) return;
    const double farthest = (bounds.largest_px - bounds.infinity_px) / (bounds.least_px - bounds.infinity_px);
    pair.warnings.push_back("where infinity lies is not known: the farthest point is taken to be at most " +
                            fixed(farthest, 1) + " times as far as the nearest");
}

void tell_aligned(PairAlignment& pair) {
    if (pair.found.estimate.is_exchanged)
        pair.warnings.push_back("the views were exchanged: " + pair.exchanged_because);
    if (pair.found.estimate.is_quarter_turned)
        pair.warnings.emplace_back(
            "the cameras stood one above the other: both pictures are turned by a quarter");
    if (const alignment::Movers& movers = pair.found.movers; movers.points > 0)
        pair.warnings.push_back(std::to_string(movers.points) + " of " + std::to_string(pair.found.matches) +
                                " points, around (" + fixed(movers.middle.x, 0) + ", " +
                                fixed(movers.middle.y, 0) +
                                ") px of the first picture, shift together as no movement of the camera to "
                                "the side explains: something moved there, a pattern repeats, or the camera "
                                "went forward, and the mesh is wrong there");
    tell_infinity(pair);
}

// Scales a relative camera so that the median depth of the matches is 1.
void set_unit(PairCamera& camera, const DisparityBounds& bounds) {
    if (camera.is_baseline_known) return;
    camera.calibration.baseline_m = (bounds.median_px - bounds.infinity_px) / camera.calibration.focal_px;
    camera.baseline_from = "not known, the median depth is 1";
}

void take_aligned(StereoPair& views, PairAlignment& pair, alignment::AlignedPair aligned) {
    views = std::move(aligned.pair);
    pair.seen = std::move(aligned.seen);
    pair.right_seen = std::move(aligned.right_seen);
    PairCamera& camera = pair.camera;
    Calibration calibration = alignment::camera_of(pair.found);
    calibration.baseline_m = camera.calibration.baseline_m;
    calibration.metric = camera.calibration.metric;
    camera.calibration = calibration;
    if (!camera.is_focal_known)
        camera.focal_from = pair.found.is_focal_determined() ? "by the points that both pictures show"
                                                             : "guessed (--fov-x DEG says it)";
    set_unit(camera, pair.found.disparities);
    tell_aligned(pair);
    pair.decisions.push_back(alignment_text(pair.found, calibration, camera.focal_from));
}

constexpr int kOrderColumns = 640;  // at which what only one view shows is looked for

// Matches views of which it is asked which is the left one. bounds: of their disparities.
stages::SmallMatch match_for_order(const StereoPair& views, const DisparityBounds& bounds, int threads) {
    const double margin_px = kNearMargin * (bounds.largest_px - bounds.least_px) + kFarMargin_px;
    return stages::match_between(views, static_cast<int>(std::floor(bounds.least_px - margin_px)),
                                 static_cast<int>(std::ceil(bounds.largest_px + margin_px)), threads,
                                 kOrderColumns);
}

// Returns the same of an aligned pair, its views in order or the other way round.
stages::SmallMatch match_aligned(const StereoPair& views, Alignment found, bool is_in_order, int threads) {
    const int by = std::max(1, found.canvas.width / kOrderColumns);
    for (int* const length : {&found.canvas.left_x, &found.canvas.right_x, &found.canvas.y,
                              &found.canvas.width, &found.canvas.height})
        *length /= by;
    DisparityBounds& bounds = found.disparities;
    for (double* const px : {&bounds.least_px, &bounds.largest_px}) *px /= by;
    StereoPair aligned = alignment::aligned_pair(reduced(views, by, threads).views, found, threads).pair;
    if (is_in_order) return match_for_order(aligned, bounds, threads);
    return match_for_order({std::move(aligned.right), std::move(aligned.left)},
                           {.least_px = -bounds.largest_px, .largest_px = -bounds.least_px}, threads);
}

// True if nearly all of a pair lies behind infinity.
bool is_nearly_behind(const DisparityBounds& bounds) {
    return -bounds.least_px > kMostBehind * bounds.largest_px;
}

// True if the pair would be inside out: what only one of its views shows tells surely that the left one is
// the right one. Rows hardly tell which way two cameras moved, and a stereo window says nothing; if they tell
// that all lies in front in the order as given, that is believed.
bool is_inside_out(const StereoPair& views, const Alignment& found, bool is_rig, int threads) {
    const bool is_known = found.disparities.is_infinity_known;
    if (!found.says_camera() || (is_known && (is_rig || !found.estimate.is_exchanged))) return false;
    if (!is_aligned(found) && !is_rig && is_nearly_behind(found.disparities))
        return false;  // the checks tell
    return checks::is_surely_right(is_aligned(found) ? match_aligned(views, found, true, threads)
                                                     : match_for_order(views, found.disparities, threads));
}

constexpr const char* kShifted =
    "all that both pictures show lies behind infinity: taken for a pair shifted for a stereo window; if the "
    "mesh is inside out, give the pictures the other way round";

// True if an aligned pair should not have been exchanged: cameras that are hardly turned to each other stand
// on one mount, whose pictures are shifted for a stereo window more often than they are given the wrong way
// round, and what only one of them shows does not tell otherwise.
bool is_wrongly_exchanged(const StereoPair& views, const Alignment& found, int threads) {
    constexpr double kOneMount_deg = 1;  // mounts that were tried are off by 0.6 at most
    if (!is_aligned(found) || !found.estimate.is_exchanged || found.estimate.is_quarter_turned) return false;
    const alignment::Angles angles = alignment::angles_of(found.estimate.fit.parameters);
    if (std::max({std::fabs(angles.pitch), std::fabs(angles.yaw), std::fabs(angles.roll)}) > kOneMount_deg)
        return false;
    return !checks::is_surely_right(match_aligned(views, found, false, threads));
}

// Returns the order that the views have, which may be another than the points tell.
Order order_of(const StereoPair& views, const Alignment& found, bool is_rig, int threads) {
    if (is_wrongly_exchanged(views, found, threads)) return Order::as_given;
    if (!is_inside_out(views, found, is_rig, threads)) return Order::by_points;
    return found.estimate.is_exchanged ? Order::as_given : Order::exchanged;
}

// Turns a pair to the order that its views have.
void turn_to(Order order, Alignment turned, PairAlignment& pair) {
    const bool is_turned = is_aligned(turned);
    if (!is_turned && (order != Order::as_given || turned.verdict != Verdict::rectified)) {
        pair.warnings.emplace_back(
            "the order of the views is not sure, and in the other one they cannot be aligned: the mesh may "
            "be "
            "inside out");
        return;
    }
    pair.found = std::move(turned);
    if (order == Order::exchanged)
        pair.exchanged_because = "in the order as given, far things would hide near ones";
    else if (is_turned)
        pair.warnings.emplace_back(kShifted);
}

void leave_rectified(const StereoPair& views, PairAlignment& pair, bool is_rig, int threads) {
    DisparityBounds& bounds = pair.found.disparities;
    pair.decisions.push_back("alignment: none, rows are off by " +
                             fixed(pair.found.estimate.before.median_px, 2) + " px in the median of " +
                             std::to_string(pair.found.matches) + " points");
    // Two files whose points nearly all lie behind infinity may be exchanged, which the checks tell.
    if (!is_rig && is_nearly_behind(bounds)) {
        if (checks::is_surely_left(match_for_order(views, bounds, threads)))
            pair.warnings.emplace_back(kShifted);
        else
            bounds = {};
    }
    if (!pair.found.is_partly_negative()) return;
    pair.camera.calibration.doffs_px = -bounds.infinity_px;
    set_unit(pair.camera, bounds);
    tell_infinity(pair);
}

}  // namespace

bool has_to_be_looked_at(const config::InputConfig& config) {
    if (config.rectify == config::PairRectification::always) return true;
    const config::CalibrationConfig& camera = config.calibration;
    return config.rectify == config::PairRectification::automatic && camera.file.empty() &&
           std::isnan(camera.cx) && std::isnan(camera.cy) && std::isnan(camera.doffs_px);
}

PairAlignment align_pair(StereoPair& views, PairCamera camera, const PairToAlign& given, int threads) {
    const bool always = given.config.rectify == config::PairRectification::always;
    const double focal_px = camera.is_focal_known ? camera.calibration.focal_px : 0;
    const auto in_order = [&](Order order) {
        return alignment::find_alignment(views, {focal_px, given.is_rig, always, order}, threads);
    };
    PairAlignment pair{{}, std::move(camera)};
    if (!given.sizes_differ.empty()) {
        pair.warnings.push_back(cut_to_one_size(views));
        if (pair.warnings.back().empty()) throw Error(ErrorKind::input, given.sizes_differ);
    }
    pair.found = in_order(Order::by_points);
    const auto start_resampling = [&] {
        return start_work(threads, [&views, &given, threads, found = pair.found] {
            return found.verdict == Verdict::aligned && !given.has_mask
                       ? alignment::aligned_pair(views, found, threads, !given.is_foreseen)
                       : alignment::AlignedPair{};
        });
    };
    auto resampling = start_resampling();  // meanwhile: the points' order is nearly always the views'
    if (const Order order = order_of(views, pair.found, given.is_rig, threads); order != Order::by_points) {
        resampling = {};  // waits for it, and frees its pictures
        turn_to(order, in_order(order), pair);
        resampling = start_resampling();
    }
    const Alignment& found = pair.found;
    // A pair that was cropped is hardly rectified.
    if (!given.sizes_differ.empty() && !is_aligned(found))
        throw Error(ErrorKind::input,
                    given.sizes_differ + (found.reason.empty() ? "" : " (" + found.reason + ")"));
    if (found.verdict == Verdict::refused || (always && found.verdict == Verdict::unclear))
        throw Error(ErrorKind::input, "the pair cannot be aligned: " + found.reason +
                                          "; give its calibration by --calib, or try --rectify never (" +
                                          given.name + ")");
    if (found.verdict == Verdict::unclear)
        pair.decisions.push_back("alignment: " + found.reason + ", so the pair is taken as it is");
    if (found.verdict == Verdict::rectified) leave_rectified(views, pair, given.is_rig, threads);
    if (found.verdict == Verdict::aligned) {
        if (given.has_mask)
            throw Error(
                ErrorKind::input,
                "the mask is for the left picture as it is, but the pair has to be aligned; give it as "
                "the picture's alpha, or --rectify never (" +
                    given.name + ")");
        take_aligned(views, pair, resampling.get());
    }
    pair.found.estimate.matches.clear();
    return pair;
}

std::array<double, 2> up_if_turned(const Alignment& found) {
    constexpr double kCosine = 0.9397;  // of 20 degrees
    const std::array<double, 2> up = alignment::up_of(found);
    return up[1] < kCosine ? up : std::array<double, 2>{0, 1};
}

Calibration flattened(Calibration camera, const Alignment& found, const ReliefMap& relief) {
    constexpr double kFar = 0.005, kNear = 0.995;  // quantiles, as for the matches
    constexpr double kLeastNoises = 400;           // in the width of the far end
    const DisparityMap& map = relief.map;
    std::vector<float> known = known_values(map);
    if (!found.is_relief() || known.empty()) return camera;
    const auto quantile = [&](double share) {
        const double rank = share * static_cast<double>(known.size() - 1);
        return static_cast<double>(value_at_rank(known, static_cast<std::size_t>(rank)));
    };
    const DisparityBounds& matches = found.disparities;
    const double least = quantile(kFar), most = quantile(kNear),
                 median = matches.median_px / relief.reduced_by;
    const double by_matches = least - (most - least) * (matches.least_px - matches.infinity_px) /
                                          (matches.largest_px - matches.least_px),
                 by_noise = most - kLeastNoises * relief.noise_px * camera.focal_px / map.width;
    const double infinity = std::min(by_matches, by_noise);
    if (!(-infinity > camera.doffs_px)) return camera;
    camera.baseline_m *= (median - infinity) / (median + camera.doffs_px);
    camera.doffs_px = -infinity;
    return camera;
}

std::string alignment_text(const Alignment& found, const Calibration& camera, const std::string& focal_from) {
    const alignment::Estimate& estimate = found.estimate;
    const alignment::Angles angles = alignment::angles_of(estimate.fit.parameters);
    return "aligned: rows were off by " + fixed(estimate.before.median_px, 2) +
           " px in the median and are by " + fixed(estimate.held_out.median_px, 2) + " px; pitch " +
           fixed(angles.pitch, 2) + ", yaw " + fixed(angles.yaw, 2) + ", roll " + fixed(angles.roll, 2) +
           " degrees; focal length of " + fixed(camera.focal_px, 0) + " px: " + focal_from +
           (camera.metric ? "" : "; relative units (--calib FILE says metres)");
}

double nearest_px(const Alignment& found) {
    if (!found.says_camera()) return std::numeric_limits<double>::infinity();
    const DisparityBounds& bounds = found.disparities;
    return bounds.largest_px + kNearMargin * (bounds.largest_px - bounds.least_px) + kNearMargin_px;
}

int largest_speckle_px(const Image& picture) {
    constexpr double kShare = 1. / 1700;  // what 100 px are of the pictures that matching was tuned on
    const double area = kShare * picture.width * picture.height;
    return std::clamp(static_cast<int>(area), 100,
                      static_cast<int>(stages::DisparityConfig::kSpeckleWindow_px.max));
}

stages::DisparityConfig with_range_of(const Alignment& found, int width, const config::Config& config) {
    stages::DisparityConfig searched = config.disparity;
    if (!found.says_camera()) return searched;
    const DisparityBounds& bounds = found.disparities;
    const double spread = bounds.largest_px - bounds.least_px;
    const double least = std::max(bounds.least_px - kFarMargin * spread - kFarMargin_px, bounds.infinity_px),
                 most = nearest_px(found);
    const int columns = std::min(width, stages::kLargestRange_px);
    if (!config.given.contains("disparity.min_disparity_px"))
        searched.min_disparity_px = std::clamp(static_cast<int>(std::floor(least)), 1 - columns, columns - 1);
    if (!config.given.contains("disparity.num_disparities_px"))
        searched.num_disparities_px = std::clamp(
            static_cast<int>(std::ceil(most)) - searched.min_disparity_px + 1, 16,
            std::max(16,
                     std::min(columns, stages::kLargestRange_px - std::max(0, searched.min_disparity_px))));
    return searched;
}

}  // namespace hexrelief::job
