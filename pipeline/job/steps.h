// What a run makes of a disparity map, step by step: values in, a value out.
#pragma once

#include <string>
#include <vector>

#include "mesher/mesher.h"
#include "pipeline/budget/budget.h"
#include "pipeline/checks/check_pair.h"
#include "pipeline/data/bounds.h"
#include "pipeline/data/calibration.h"
#include "pipeline/data/density_map.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/image.h"
#include "pipeline/data/surface_mesh.h"
#include "pipeline/job/backend.h"
#include "pipeline/job/run_log.h"
#include "pipeline/readers/depth/mask_reader.h"
#include "pipeline/stages/surface_quality.h"
#include "pipeline/stages/surface_topology.h"

namespace hexrelief::job {

// What every step is given besides its values.
struct RunContext {
    const Backend& backend;
    int threads;
    RunLog& log;
};

// A disparity map, and what it was made with where it comes from a pair.
struct DisparityResult {
    DisparityMap map;
    bool is_matched = false;         // false: it was read
    stages::DisparityConfig config;  // with the range searched
    double quantum_px = 0;           // step that was smoothed; 0 = none
    DisparityMap smooth = {};        // without those steps; empty where there are none

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

struct SpaceSurface {
    SurfaceMesh mesh;
    Bounds bounds;
    double device_s = 0;  // cutting and fitting, on the device's own clock; 0 on the CPU
};

// A surface, with the lattice and the configuration that it was made with.
struct SurfaceResult {
    config::Config config;  // in effect: a budget changes the spacing, and tolerance_share the tolerance
    mesher::MeshResult lattice;
    quality::MeshQuality quality;  // of the lattice
    SpaceSurface surface;
    budget::BudgetResult budget;  // what the search for the spacing found; no kind = no budget
};

// A coarser level of detail.
struct DetailLevel {
    double spacing_px = 0;
    SurfaceMesh mesh;
};

// The surface against the disparity map.
struct SurfaceMeasures {
    stages::Topology topology;
    stages::SurfaceQuality quality;
};

// What match_input() needs besides the pair, and where its range comes from.
struct ChosenRange : stages::RangedPair {
    StereoPair corrected = {};  // what is matched: the pair in one light, with less noise
    checks::RangeOrigin origin = checks::RangeOrigin::chosen;
};

// The disparities below a calibration's ndisp that can be searched in pictures of this width; 0 where the
// configuration has a range of its own, or the calibration says none.
int num_disparities_by(const Calibration& calibration, const stages::DisparityConfig& config, int width);
// What is told of a range.
std::string range_text(const stages::DisparityConfig& ranged, checks::RangeOrigin origin);

// The configuration's own range, else the calibration's, else the one that a small match of the pair finds.
ChosenRange choose_range(const StereoPair& pair, const Calibration& calibration,
                         const stages::DisparityConfig& config, int threads, const RunLog& log);

// Refuse a pair that has nothing to match, and one of which nothing was.
void check_detail(bool is_left_blank, bool is_right_blank);
void check_matches(bool has_any);

DisparityResult match_input(const StereoPair& pair, const ChosenRange& range, const RunContext& run);

// A supplied map; where it is sparse and the configuration lets it, filled between its measurements in a
// stage "densify", but for what the mask hides. Then alone it has origins. left, mask: empty = none.
DisparityMap densify_input(DisparityMap map, const Image& left, const readers::PixelMask& mask,
                           const config::Config& config, const RunContext& run);

// With doffs, points as far as a disparity of -doffs have a depth, but what is 0 or less would be left out.
// Where there is such, doffs is added to all disparities, and the calibration has none: the same points.
void count_from_infinity(DisparityResult& disparity, Calibration& calibration, const RunLog& log);

// A supplied map, without its steps where the configuration asks for that.
DisparityResult smooth_input(DisparityMap map, const config::Config& config, const RunContext& run);

// Throws Error(input) where nothing is foreground.
DensityMap density_of(const DisparityMap& disparity, const stages::DensityConfig& config, int threads,
                      const RunLog& log);

// Stages mesh, surface and quality, whose work goes on beside the surface's, and tolerance where the
// configuration asks for it.
SurfaceResult make_surface(const LeftView& view, const config::Config& config, const RunContext& run);

// The configuration with its tolerance lowered by the surface's own error (tolerance.h), where
// export.tolerance_share asks for that; else unchanged.
config::Config with_tolerance(const config::Config& config, const SurfaceMesh& surface, const LeftView& view,
                              const RunContext& run);

void warn_of_inversions(const quality::MeshQuality& quality, RunLog& log);

// export.lod - 1 meshes, each at twice the spacing of the one before. Throws as make_surface().
std::vector<DetailLevel> coarser_levels(const LeftView& view, const config::Config& config,
                                        const RunContext& run);

// The topology of the surface, and the quality of the same as files hold it (tolerance.h). Takes as long as
// a good part of the surface stage: only for a report.
SurfaceMeasures measure_surface(const SurfaceMesh& surface, const SurfaceMesh& written, const LeftView& view,
                                const RunContext& run);

}  // namespace hexrelief::job
