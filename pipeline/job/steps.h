// Steps of a run from a pair or a map to the surface: values in, a value out.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mesher/mesher.h"
#include "pipeline/data/bounds.h"
#include "pipeline/data/calibration.h"
#include "pipeline/data/density_map.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/image.h"
#include "pipeline/data/surface_mesh.h"
#include "pipeline/job/backend.h"
#include "pipeline/job/budget/budget.h"
#include "pipeline/job/input.h"
#include "pipeline/job/log/run_log.h"
#include "pipeline/readers/depth/mask_reader.h"
#include "pipeline/stages/dequantize/noise.h"
#include "pipeline/stages/disparity.h"
#include "pipeline/stages/disparity_range.h"
#include "pipeline/stages/other_views/other_view.h"
#include "pipeline/stages/other_views/texture_atlas.h"
#include "pipeline/stages/surface_quality.h"
#include "pipeline/stages/surface_topology.h"

namespace hexrelief::job {

// A disparity map, matched or supplied.
struct DisparityResult {
    DisparityMap map;
    std::optional<stages::DisparityConfig> matched;  // with the range searched; none = the map was supplied
    double quantum_px = 0;                           // quantisation step that was smoothed; 0 = none
    DisparityMap smooth = {};                        // the map without these steps; empty = no steps
    double support = 0;                              // of a matched map by its pair (checks/pair_support.h)
    stages::NoiseSmoothing noise = {};               // of a matched map
    std::optional<stages::Backdrop> backdrop = {};   // of a matched map; none = it has no end
    bool has_filled_holes = false;  // the map's filled pixels are holes of the one that was supplied

    const DisparityMap& meshed() const { return quantum_px > 0 ? smooth : map; }
};

// The left camera's view. All members have one size except the texture.
struct LeftView {
    const DisparityMap& disparity;  // the reference for measures of the surface
    const DisparityMap& meshed;     // the map that is meshed, without a rounded map's steps
    const DensityMap& density;
    const Image& color;    // empty = none
    const Image& texture;  // the same picture at its original size; empty = none
    const Calibration& calibration;
    const Calibration& pair_camera;            // with the doffs that `calibration` may have in the map
    float least_px = 0;                        // no vertex has a smaller disparity
    const stages::OtherView* right = nullptr;  // null = there is none
    bool is_whole = false;                     // RunInput::is_whole()
    const std::vector<std::uint8_t>* texture_file = nullptr;  // as in exporters::Scene
    static constexpr std::array<double, 2> kUpright = {0, 1};
    std::array<double, 2> up = kUpright;  // as in exporters::Scene
    bool is_by_points = false;            // has_camera_of_points()
    bool has_filled_holes = false;        // as in DisparityResult: no measure counts them
    double quantum_px = 0;                // as in DisparityResult
    // True if the map was matched, or filled between measurements.
    bool is_measured() const { return !disparity.origins.empty() && !has_filled_holes; }
    // True if its disparities have noise or steps that are no shape.
    bool is_uneven() const { return quantum_px > 0 || is_measured(); }
};

// A surface with the lattice and the configuration that it was made from.
struct SurfaceResult {
    config::Config config;  // in effect: a budget changes the spacing, and tolerance_share the tolerance
    HexMesh2D lattice;
    quality::MeshQuality quality;  // of the lattice
    SurfaceMesh mesh;
    // The part of the mesh that the left camera does not see.
    struct OtherViews {
        std::vector<stages::OtherView> views;
        stages::TextureAtlas atlas;
    };
    std::shared_ptr<const OtherViews> others;  // null = the mesh is that of the left view only
    Bounds bounds, left_bounds;                // of the mesh, and of its part that the left camera sees
    DeviceFigures device;
    job::BudgetResult budget;  // result of the search for the spacing; no kind = no budget

    // Depths of that part along the left camera's axis, in metres or relative units.
    double nearest() const { return -static_cast<double>(left_bounds.high.z); }
    double farthest() const { return -static_cast<double>(left_bounds.low.z); }
    // The picture that the texture coordinates refer to; null = none.
    const Image* texture(const LeftView& view) const {
        if (view.texture.empty()) return nullptr;
        return others ? &others->atlas.picture : &view.texture;
    }
};

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
                   RunLog& log);

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

// Refines the map of photographs by themselves (dequantize/by_pictures.h) if their points say their camera
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
