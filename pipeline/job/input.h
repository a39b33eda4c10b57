// Input of a run, read and prepared for the stages.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "pipeline/alignment/alignment.h"
#include "pipeline/data/calibration.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/job/cameras/resolve_calibration.h"
#include "pipeline/job/log/run_log.h"
#include "pipeline/job/request.h"
#include "pipeline/readers/depth/mask_reader.h"

namespace hexrelief::job {

// A rectified pair, ready to be matched.
struct InputPair {
    StereoPair views;          // at the working size (pairs/working_size.h)
    StereoPair pictures = {};  // at their own size, if that differs from the views'; else empty
    int reduced_by = 1;        // px of these pictures along a side of the views' px
    // Pixels of the right view that lie inside the picture as taken; empty = all.
    readers::PixelMask right_mask = {};
    bool is_masked = false;     // true if a mask other than the alignment's hides a part of the left view
    bool is_rectified = false;  // true if the program rectified it, by its calibration file or its points
    // What its points showed, without the matches; none if they were not looked for.
    std::optional<alignment::Alignment> alignment = {};

    // True if its camera is what its points say.
    bool is_of_points() const { return alignment && alignment->says_camera(); }
};

// A supplied disparity map, or a supplied depth map converted to disparities.
struct InputMap {
    DisparityMap disparities;
    Image color;  // the left picture at the map's size; empty = none
    // The left picture at its own size, if that differs from the map's; else empty.
    Image picture = {};
    std::string read_as = {};  // how its samples were read: "16-bit integers, mm"; empty = it was in memory
    bool is_depth = false;     // true if it was a depth map
    // The right view, of the same sizes; without a map it was not supplied, and its picture alone checks the
    // left view's map.
    DisparityMap right = {};
    Image right_color = {}, right_picture = {};
};

struct RunInput {
    std::variant<InputPair, InputMap> views;
    // Pixels of the left view that the map keeps after it is matched or filled; empty = all. In a supplied
    // map the other pixels are unknown already.
    readers::PixelMask mask = {};
    Calibration calibration = {};                     // in effect, for the left view's size
    std::string focal_from = {}, baseline_from = {};  // as in ResolvedCalibration, or "the nearest distance"
    std::vector<InputFile> files = {};
    std::vector<std::uint8_t> texture_file = {};  // the left picture's, if the texture may keep some of it

    // True if a pair was aligned by its own points.
    bool is_aligned() const {
        return pair() && pair()->alignment && pair()->alignment->verdict == alignment::Verdict::aligned;
    }
    // True if a pair's depths are a guess, because its points do not tell where infinity lies.
    bool is_relief() const { return pair() && pair()->alignment && pair()->alignment->is_relief(); }
    // Returns the calibration in effect as text, with the origins of focal length and baseline.
    std::string camera_text() const { return job::camera_text(calibration, focal_from, baseline_from); }
    const InputPair* pair() const { return std::get_if<InputPair>(&views); }
    const InputMap* map() const { return std::get_if<InputMap>(&views); }
    // color(): the left picture at the view's size; texture(): the same at its original size. Empty = none.
    const Image& color() const { return pair() ? pair()->views.left : map()->color; }
    const Image& texture() const {
        const Image& picture = pair() ? pair()->pictures.left : map()->picture;
        return picture.empty() ? color() : picture;
    }
    // True if what the left camera does not see can become part of the surface: no mask cuts a thing out of
    // its view.
    bool is_whole() const { return mask.empty() || (is_aligned() && pair()->views.left.alpha.empty()); }
    int reduced_by() const { return pair() ? pair()->reduced_by : 1; }
};

// Returns the names of the files that save_rectified()
// writes: left_rectified.png right_rectified.png calib.txt.
const std::vector<std::filesystem::path>& rectified_file_names();

// Reads a source's files, or moves its arrays out of it. Warns of a missing calibration, except
// for a pair in memory. Throws Error(input)
// if a file cannot be read or sizes differ.
RunInput read_input(Source source, const config::InputConfig& config, const readers::ReaderLimits& limits,
                    int threads, RunLog& log);

// Returns what read_input() returns, but for the right picture of a pair that is aligned, which is empty.
RunInput foresee_input(Source source, const config::InputConfig& config, const readers::ReaderLimits& limits,
                       int threads, RunLog& log);

}  // namespace hexrelief::job
