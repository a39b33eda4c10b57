// What a run makes, before anything is written: the results of its stages.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mesher/mesher.h"
#include "pipeline/config/config.h"
#include "pipeline/data/bounds.h"
#include "pipeline/data/calibration.h"
#include "pipeline/data/density_map.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/image.h"
#include "pipeline/data/surface_mesh.h"
#include "pipeline/job/backend.h"
#include "pipeline/job/budget/budget.h"
#include "pipeline/job/input.h"
#include "pipeline/stages/dequantize/noise.h"
#include "pipeline/stages/disparity.h"
#include "pipeline/stages/disparity_range.h"
#include "pipeline/stages/other_views/other_view.h"
#include "pipeline/stages/other_views/texture_atlas.h"

namespace hexrelief::job {

// A disparity map, matched or supplied.
struct DisparityResult {
    DisparityMap map;
    std::optional<stages::DisparityConfig> matched;  // with the range searched; none = the map was supplied
    double quantum_px = 0;                           // quantisation step that was smoothed; 0 = none
    DisparityMap smooth = {};                        // the map without these steps; empty = no steps
    double support = 0;                             // of a matched map by its pair (checks/pair_statistics.h)
    stages::NoiseSmoothing noise = {};              // of a matched map
    std::optional<stages::Backdrop> backdrop = {};  // of a matched map; none = it has no end
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
    bool is_by_points = false;            // InputPair::is_of_points()
    bool has_filled_holes = false;        // as in DisparityResult: no measure counts them
    double quantum_px = 0;                // as in DisparityResult
    bool is_matched = false;              // the map is a pair's
    bool is_masked = false;               // InputPair::is_masked
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
    BudgetResult budget;  // result of the search for the spacing; no kind = no budget

    // Depths of that part along the left camera's axis, in metres or relative units.
    double nearest() const { return -static_cast<double>(left_bounds.high.z); }
    double farthest() const { return -static_cast<double>(left_bounds.low.z); }
    // The picture that the texture coordinates refer to; null = none.
    const Image* texture(const LeftView& view) const {
        if (view.texture.empty()) return nullptr;
        return others ? &others->atlas.picture : &view.texture;
    }
};

// The results of all stages.
struct Relief {
    RunInput input;
    std::shared_ptr<Backend> backend;
    std::string backend_reason;  // why this backend was chosen
    DisparityResult disparity;
    Calibration pair_camera;  // the input's before its disparities were counted from infinity
    DensityMap density;
    std::optional<stages::OtherView> right;  // none = the surface is made of the left view only
    SurfaceResult surface;

    // Returns a view that refers to this relief.
    LeftView view() const;
    double depth_of_backdrop() const;  // 0 = there is none
    std::string support() const;       // of the map by its pair, in a word; empty = it was supplied
};

// Shares of the picture, 0..1. Known pixels are foreground or background, the others unknown or
// occluded; these four add up to 1. The mesh covers the foreground except slivers along its borders, and
// bridges small unknown regions.
struct PictureShares {
    double meshed = 0;      // by triangles
    double foreground = 0;  // known, and not removed as background
    double background = 0;
    double occluded = 0;  // unknown because the right camera cannot see it
    double unknown = 0;   // unknown for another reason

    double known() const { return foreground + background; }
};

// Measures the shares. `background_px` as in DensityMap; the surface's first `triangles` were made from
// `map`. blank: number of unknown pixels that no picture shows, which are of no share.
PictureShares share_picture(const DisparityMap& map, float background_px, const SurfaceMesh& surface,
                            std::size_t triangles, std::size_t blank = 0);

}  // namespace hexrelief::job
