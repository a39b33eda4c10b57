// Decides whether a pair has to be aligned, and how, which disparities it has, and where infinity is: the
// room's interface, with resample.h.
#pragma once

#include <string>

#include "pipeline/alignment/estimate.h"
#include "pipeline/data/disparity_map.h"

namespace hexrelief::alignment {

struct AlignmentConfig {
    double focal_px = 0;             // of both pictures, as a file or the user gives it; 0 = not known
    bool is_rig = false;             // as in EstimateConfig
    bool always = false;             // aligns pairs whose rows are hardly off, too
    Order order = Order::by_points;  // exchanged: aligned always
};

enum class Verdict {
    rectified,  // rows are the same already, or so nearly that a correction would not be significant
    aligned,
    unclear,  // too few points are found to tell
    refused,  // no movement of a camera explains the points, or not one that shows depth
};

// The part of the rectified views that becomes the pair, in px of the pictures as given, from the principal
// point. Both views have one size and the same rows.
struct Canvas {
    int left_x = 0, right_x = 0, y = 0, width = 0, height = 0;
};

// The disparities of the pair, in px of the pair that the verdict leaves: as given, or aligned.
struct DisparityBounds {
    double least_px = 0, largest_px = 0;  // of nearly all matches that their neighbours support
    double median_px = 0;
    double infinity_px = 0;
    // False if the farthest point may be anywhere: the scene is then taken to be a quarter as deep as it
    // is wide.
    bool is_infinity_known = false;
};

struct Alignment {
    Verdict verdict = Verdict::unclear;
    std::string reason;          // what was seen, as one sentence; if refused or unclear
    int matches = 0;             // points found in both pictures
    Estimate estimate;           // if aligned, refused or fitted; the figures of all verdicts but unclear
    double focal_px = 0;         // of the aligned views
    double focal_deviation = 0;  // share of focal_px, one standard deviation; 0 = given
    DisparityBounds disparities = {};  // if rectified or aligned
    Canvas canvas = {};                // if aligned
    Movers movers = {};                // if aligned; in px of the first picture as given

    // True if the focal length was given, or the matches determine it.
    bool is_focal_determined() const;
    // True if the pair's camera is what its points say: it was aligned, or its infinity is not at 0.
    bool says_camera() const { return verdict == Verdict::aligned || is_partly_negative(); }
    // True if a rectified pair shows disparities that are below 0 for sure.
    bool is_partly_negative() const { return verdict == Verdict::rectified && disparities.least_px < -1; }
    // True if the pair's depths are a guess, because infinity may lie anywhere.
    bool is_relief() const { return says_camera() && !disparities.is_infinity_known; }
};

// Looks for points in both pictures and decides. The pictures have one size. The same bits for any number of
// threads.
Alignment find_alignment(const StereoPair& pair, const AlignmentConfig& config, int threads);

// Returns the bounds of the estimate's views, in px of the pictures as given. scale: px of the matches'
// pictures per px of those.
DisparityBounds bounds_of(const Estimate& estimate, bool is_focal_known, double scale);

// Returns the same for a pair that stays as it is.
DisparityBounds bounds_as_given(const Estimate& estimate, double scale);

// Returns an estimate that leaves the pair as it is; near rows agree.
Estimate as_given(const Camera& camera, std::vector<Match> matches);

}  // namespace hexrelief::alignment
