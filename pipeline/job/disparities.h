// The disparities of a run: matched or supplied, and what is made of them before they are meshed.
#pragma once

#include <string>

#include "pipeline/job/backend.h"
#include "pipeline/job/input.h"
#include "pipeline/job/log/run_log.h"
#include "pipeline/job/relief.h"
#include "pipeline/stages/disparity.h"
#include "pipeline/stages/disparity_range.h"

namespace hexrelief::job {

// Returns by what reduce_pair() reduces an input, and logs it if that is more than 1.
int find_reduction(const RunInput& input, const stages::DisparityConfig& config, int threads,
                   const RunLog& log);

// Reduces a pair that is larger than config.working_px, its mask and its calibration; the left picture stays
// as InputPair::pictures.left. Does nothing to a map. Throws as stages::check_matchable().
void reduce_pair(RunInput& input, const stages::DisparityConfig& config, int threads, const RunLog& log);

// Returns the log's line about a range.
std::string range_text(const stages::DisparityConfig& searched, stages::RangeOrigin origin);

// Throw Error(input) if a picture is blank, or if nothing was matched.
void check_detail(bool is_left_blank, bool is_right_blank);
void check_matches(bool has_any);

// Matches the corrected pair in the range found. Throws as check_detail(), which looks
// at `pair`, and check_matches().
DisparityResult disparities_of_pair(const InputPair& pair, const StereoPair& corrected,
                                    const stages::DisparityConfig& searched, Backend& backend);

// Returns the disparities of a pair by both views' maps of a program of the user's. Throws as check_detail()
// and check_matches().
DisparityResult disparities_of_program(const StereoPair& pair, const stages::ViewMaps& maps,
                                       const stages::DisparityConfig& config, int threads);

// Cuts the blurred steps of both views' maps along their pictures' edges, if the maps are dense.
void sharpen_maps(stages::ViewMaps& maps, const StereoPair& pair, int threads, const RunLog& log);

// Tells how well the pair supports its map, and warns if hardly; then throws Error(input) if `strict`.
void judge_support(DisparityResult& disparity, const InputPair& pair, const readers::PixelMask& mask,
                   bool strict, int threads, RunLog& log);

// Return the disparities of a supplied map, and its right view's: filled, sharpened, checked and smoothed as
// configured.
DisparityResult supplied_disparities(InputMap& input, const readers::PixelMask& mask,
                                     const config::Config& config, int threads, RunLog& log);
stages::OtherView supplied_right_view(InputMap& input, const config::Config& config, int threads,
                                      RunLog& log);

// Puts a backdrop behind a matched map, if configured.
void end_scene(DisparityResult& disparity, const Calibration& calibration, const SurfaceConfig& config,
               const RunLog& log);

// Adds doffs to all disparities and sets the calibration's doffs to 0, if doffs is above 0 and some
// disparities are 0 or less, or if `always`. The points stay the same. Without this, disparities from -doffs
// to 0, which have a depth, would be left out.
void count_from_infinity(DisparityResult& disparity, Calibration& calibration, bool always,
                         const RunLog& log);

// Returns how many baselines beside the camera a scene is seen from if it is turned by 20 degrees, by 30
// of_photographs that their points aligned, about its median depth, to a tenth, at least 1 and at most 8.
// camera: with the doffs of the map's disparities.
double baselines_of_turn(const DisparityMap& map, const Calibration& camera, bool of_photographs);

// Makes the map that is meshed of a relief's disparities: moves, refines and smooths what a pair's matches do
// not support, ends the scene, and counts from infinity. Sets the relief's pair_camera, and surface.behind by
// baselines_of_turn() unless it is given.
void finish_disparities(Relief& relief, config::Config& config, RunLog& log);

}  // namespace hexrelief::job
