// Steps of a run from a pair or a map to the surface: values in, a value out.
#pragma once

#include <string>
#include <vector>

#include "mesher/mesher.h"
#include "pipeline/job/backend.h"
#include "pipeline/job/input.h"
#include "pipeline/job/log/run_log.h"
#include "pipeline/job/relief.h"
#include "pipeline/readers/depth/mask_reader.h"
#include "pipeline/stages/disparity.h"
#include "pipeline/stages/disparity_range.h"

namespace hexrelief::job {

// Returns the log's line about a range.
std::string range_text(const stages::DisparityConfig& searched, stages::RangeOrigin origin);

// Throw Error(input) if a picture is blank, or if nothing was matched.
void check_detail(bool is_left_blank, bool is_right_blank);
void check_matches(bool has_any);

// Matches the corrected pair in the range found. Throws as check_detail(), which looks
// at `pair`, and check_matches().
DisparityResult disparities_of_pair(const StereoPair& pair, const StereoPair& corrected,
                                    const stages::DisparityConfig& searched, Backend& backend);

// Returns the disparities of a pair by both views' maps of a program of the user's. Throws as check_detail()
// and check_matches().
DisparityResult disparities_of_program(const StereoPair& pair, const stages::ViewMaps& maps,
                                       const stages::DisparityConfig& config, int threads);

// Returns a supplied map whose blurred steps are cut along the picture's edges (stages::sharpen_steps()).
DisparityMap sharpen_map(DisparityMap map, const Image& left, int threads, const RunLog& log);
// Does that to both views' maps of a matcher, if they are dense.
void sharpen_maps(stages::ViewMaps& maps, const StereoPair& pair, int threads, const RunLog& log);

// Returns a supplied map of the pair's left view, checked by the right picture (check_by_picture()); as it is
// if that picture shows something else, with a warning.
DisparityMap check_map(DisparityMap map, StereoPair pair, const stages::DisparityConfig& config, int threads,
                       RunLog& log);

// Returns a supplied map. A sparse map is filled between its measurements in a stage of its own, except at
// the pixels that the mask hides; only then the result has origins. left, mask: empty = none.
DisparityMap densify_map(DisparityMap map, const Image& left, const readers::PixelMask& mask, int threads,
                         RunLog& log);

// Tells how well the pair supports its map, and warns if hardly; then throws Error(input) if `strict`.
void judge_support(DisparityResult& disparity, const Image& left, const readers::PixelMask& mask, bool strict,
                   int threads, RunLog& log);

// Puts a backdrop behind a matched map, if configured.
void end_scene(DisparityResult& disparity, const Calibration& calibration, const SurfaceConfig& config,
               const RunLog& log);

// Moves what is nearer than nearest_px, which the matches do not support, to what is around it.
void press_near(DisparityResult& disparity, double nearest_px, const RunLog& log);

// Adds doffs to all disparities and sets the calibration's doffs to 0, if doffs is above 0 and some
// disparities are 0 or less, or if `always`. The points stay the same. Without this, disparities from -doffs
// to 0, which have a depth, would be left out.
void count_from_infinity(DisparityResult& disparity, Calibration& calibration, bool always,
                         const RunLog& log);

// Returns how many baselines beside the camera a scene is seen from if it is turned by 20 degrees, by 30
// of_photographs that their points aligned, about its median depth, to a tenth, at least 1 and at most 8.
// camera: with the doffs of the map's disparities.
double baselines_of_turn(const DisparityMap& map, const Calibration& camera, bool of_photographs);

// Refines the map of photographs by themselves (dequantize/dequantize.h) if their points say their camera
// and the map is noisy (dequantize/noise.h).
void refine_noisy(DisparityResult& disparity, const InputPair& pair, int threads, const RunLog& log);

// Makes a relief no deeper than its matches and its noise let (flattened(), pipeline/job/pairs/align_pair.h).
void flatten_relief(const DisparityResult& disparity, const InputPair& pair, Calibration& camera,
                    const RunLog& log);

// Smooths a matched map within its noise (dequantize/noise.h), if there is much and nothing refined it.
void smooth_noise(DisparityResult& disparity, int threads, const RunLog& log);

// Removes the quantisation steps from a supplied map, unless max_error_px is above 0 and less than a step.
DisparityResult smooth_map(DisparityMap map, double max_error_px, int threads, const RunLog& log);

// Fills the pixels that a supplied map does not know but its picture shows, by planes, except those that the
// mask hides. Does nothing if more than a quarter of the map is unknown, or if there is no picture.
void fill_map(DisparityResult& disparity, const Image& left, const readers::PixelMask& mask, int threads,
              const RunLog& log);

// Computes the density of a map. Warns if most of it is background. Throws Error(input) if all of it is.
DensityMap density_of(const DisparityMap& disparity, const stages::DensityConfig& config, int threads,
                      RunLog& log);

// Cuts the lattice along the view's silhouettes, and makes the cut mesh a surface in the view's space.
DisparityMesh cut_lattice(const HexMesh2D& lattice, const LeftView& view, const SurfaceConfig& config,
                          Backend& backend, const RunLog& log);
SurfaceMesh surface_of(const DisparityMesh& cut_mesh, const LeftView& view, const SurfaceConfig& config);

// Runs the stages mesh and surface, quality in parallel with surface, then tolerance if configured.
SurfaceResult make_surface(const LeftView& view, const config::Config& config, Backend& backend, RunLog& log);

// Returns the configuration, its tolerance lowered by the surface's own error (tolerance.h) if
// export.tolerance_share is above 0.
config::Config with_tolerance(const config::Config& config, const SurfaceMesh& surface, const LeftView& view,
                              int threads, const RunLog& log);

void warn_of_inversions(const quality::MeshQuality& quality, RunLog& log);

// Returns export.lod - 1 coarser levels of the surface, each at twice the spacing of the one before. Throws
// as make_surface().
std::vector<SurfaceMesh> coarser_levels(const LeftView& view, const SurfaceResult& finest, Backend& backend,
                                        const RunLog& log);

}  // namespace hexrelief::job
