// Aligns an uncalibrated pair by its own points (pipeline/alignment), as input.rectify says.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/alignment/alignment.h"
#include "pipeline/config/config.h"
#include "pipeline/data/calibration.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/image.h"

namespace hexrelief::job {

// A pair's left camera, and where its numbers come from.
struct PairCamera {
    Calibration calibration;
    bool is_focal_known = false, is_baseline_known = false;
    std::string focal_from = {}, baseline_from = {};
};

// How a pair was given.
struct PairToAlign {
    const config::InputConfig& config;
    std::string name;               // for messages
    bool is_rig = false;            // one file holds both views
    bool has_mask = false;          // a mask was given for the left view as it is
    bool is_foreseen = false;       // the right picture is not needed, and is left out if the pair is aligned
    std::string sizes_differ = {};  // the error if the pair is not aligned; empty = they are the same
};

struct PairAlignment {
    alignment::Alignment found;                            // without the matches
    PairCamera camera;                                     // of the pair that is left
    std::vector<std::uint8_t> seen = {}, right_seen = {};  // of an aligned pair, as in AlignedPair
    std::string exchanged_because = "what both pictures show lies behind the cameras as given";
    std::vector<std::string> warnings = {}, decisions = {};
};

// True if the configuration asks for a look at the pair's points: always, or under auto if no calibration
// says that the pair is rectified.
bool has_to_be_looked_at(const config::InputConfig& config);

// Replaces the pair by its aligned views if its rows have to be aligned. Sets the camera's doffs if some of a
// rectified pair lies behind infinity. camera: of the pair as it is. Throws Error(input) if the pair cannot
// be aligned. Views whose sizes differ are cut to one; the camera's focal length is the left one's before
// that.
PairAlignment align_pair(StereoPair& views, PairCamera camera, const PairToAlign& given, int threads);

inline bool is_aligned(const alignment::Alignment& found) {
    return found.verdict == alignment::Verdict::aligned;
}

// The map of a relief as it is meshed.
struct ReliefMap {
    const DisparityMap& map;
    double noise_px = 0;  // that its match had
    int reduced_by = 1;   // px of the pictures along a side of its px
};

// Returns the camera of a relief that has to be shallower than its matches tell. Infinity is farther, and the
// baseline longer, so that the unit stays. If the map spreads more than the matches, the scene stays as deep
// for its width as they were taken to be; and noise moves a point at the near end by a 400th of its distance
// times the width that is seen at a distance of 1 at most, else straight things wave when they are turned.
// Returns the given camera for other pairs. camera: the map's.
Calibration flattened(Calibration camera, const alignment::Alignment& found, const ReliefMap& relief);

// Returns what is up in an aligned pair, if it was turned by more than 20 degrees; else (0, 1), so that the
// camera's rows stay horizontal. As in exporters::Scene.
std::array<double, 2> up_if_turned(const alignment::Alignment& found);

// Returns what was done to an aligned pair as one line. camera: of the aligned pair.
std::string alignment_text(const alignment::Alignment& found, const Calibration& camera,
                           const std::string& focal_from);

// Returns the disparity of the nearest things that the matches of an aligned pair support, or of a pair whose
// disparities are partly negative; infinity for others. In px of the pair at full size.
double nearest_px(const alignment::Alignment& found);

// Returns the largest area of a patch of chance matches on a bare wall, px: the same share of a photograph of
// any size.
int largest_speckle_px(const Image& picture);

// Returns the configuration with the range that the matches of an aligned pair of this width support, or of a
// pair whose disparities are partly negative; as far as the keys of the range are not given.
stages::DisparityConfig with_range_of(const alignment::Alignment& found, int width,
                                      const config::Config& config);

}  // namespace hexrelief::job
