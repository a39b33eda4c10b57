// What a run makes of a disparity map, step by step: values in, a value out.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mesher/mesher.h"
#include "pipeline/budget/budget.h"
#include "pipeline/data/bounds.h"
#include "pipeline/data/calibration.h"
#include "pipeline/data/density_map.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/image.h"
#include "pipeline/data/surface_mesh.h"
#include "pipeline/job/backend.h"
#include "pipeline/job/run_log.h"
#include "pipeline/readers/depth/mask_reader.h"
#include "pipeline/stages/disparity.h"
#include "pipeline/stages/surface_quality.h"
#include "pipeline/stages/surface_topology.h"

namespace hexrelief::job {

// A disparity map, matched or supplied.
struct DisparityResult {
    DisparityMap map;
    std::optional<stages::DisparityConfig>
        matched;               // with the range searched; none where the map was supplied
    double quantum_px = 0;     // step that was smoothed; 0 = none
    DisparityMap smooth = {};  // without those steps; empty where there are none

    const DisparityMap& meshed() const { return quantum_px > 0 ? smooth : map; }
};

// What the left camera sees. All have one size but for the texture.
struct LeftView {
    const DisparityMap& disparity;  // what the surface is measured against
    const DisparityMap& meshed;     // what it is made from: without the steps of a rounded map
    const DensityMap& density;
    const Image& color;    // empty = none
    const Image& texture;  // the same picture at the size that it came in; empty = none
    const Calibration& calibration;
};

// A surface, with the lattice and the configuration that it was made with.
struct SurfaceResult {
    config::Config config;  // in effect: a budget changes the spacing, and tolerance_share the tolerance
    mesher::MeshResult lattice;
    quality::MeshQuality quality;  // of the lattice
    SurfaceMesh mesh;
    Bounds bounds;                // of the mesh
    double device_s = 0;          // cutting and fitting, on the device's own clock; 0 on the CPU
    budget::BudgetResult budget;  // what the search for the spacing found; no kind = no budget

    // Of the mesh, along the left camera's axis: metres, or relative units.
    double nearest() const { return -static_cast<double>(bounds.high.z); }
    double farthest() const { return -static_cast<double>(bounds.low.z); }
};

// The surface against the disparity map.
struct SurfaceMeasures {
    stages::Topology topology;
    stages::SurfaceQuality quality;
};

// What is told of a range.
std::string range_text(const stages::DisparityConfig& searched, stages::RangeOrigin origin);

// Refuse a pair that has nothing to match, and one of which nothing was.
void check_detail(bool is_left_blank, bool is_right_blank);
void check_matches(bool has_any);

// A pair, matched as it is corrected, in the range found.
DisparityResult disparities_of_pair(const StereoPair& pair, const StereoPair& corrected,
                                    const stages::DisparityConfig& searched, Backend& backend);

// A supplied map; where it is sparse, filled between its measurements in a stage "densify", but for what the
// mask hides. Then alone it has origins. left, mask: empty = none.
DisparityMap densify_map(DisparityMap map, const Image& left, const readers::PixelMask& mask, int threads,
                         RunLog& log);

// With doffs, points as far as a disparity of -doffs have a depth, but what is 0 or less would be left out.
// Where there is such, doffs is added to all disparities, and the calibration has none: the same points.
void count_from_infinity(DisparityResult& disparity, Calibration& calibration, const RunLog& log);

// A supplied map, without its steps, unless these are more than max_error_px, where that is above 0.
DisparityResult smooth_map(DisparityMap map, double max_error_px, int threads, const RunLog& log);

// Throws Error(input) where nothing is foreground.
DensityMap density_of(const DisparityMap& disparity, const stages::DensityConfig& config, int threads,
                      const RunLog& log);

// Stages mesh, surface and quality, whose work goes on beside the surface's, and tolerance where the
// configuration asks for it.
SurfaceResult make_surface(const LeftView& view, const config::Config& config, Backend& backend, RunLog& log);

// The configuration with its tolerance lowered by the surface's own error (tolerance.h), where
// export.tolerance_share asks for that; else unchanged.
config::Config with_tolerance(const config::Config& config, const SurfaceMesh& surface, const LeftView& view,
                              int threads, const RunLog& log);

void warn_of_inversions(const quality::MeshQuality& quality, RunLog& log);

// export.lod - 1 meshes, each at twice the spacing of the one before. Throws as make_surface().
std::vector<SurfaceMesh> coarser_levels(const LeftView& view, const config::Config& config, Backend& backend,
                                        const RunLog& log);

// The topology of the surface, and the quality of the same as files hold it (tolerance.h). Takes as long as
// a good part of the surface stage: only for a report.
SurfaceMeasures measure_surface(const SurfaceMesh& surface, const SurfaceMesh& written, const LeftView& view,
                                int threads, const RunLog& log);

}  // namespace hexrelief::job
