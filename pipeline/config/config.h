// The whole configuration: one struct per stage, as the top-level sections of YAML.
#pragma once

#include <limits>
#include <set>
#include <string>
#include <vector>

#include "exporters/core/scene.h"
#include "mesher/common/mesh_config.h"
#include "mesher/common/surface_config.h"
#include "pipeline/readers/cameras/calibration_reader.h"
#include "pipeline/readers/depth/depth_reader.h"
#include "pipeline/readers/depth/mask_reader.h"
#include "pipeline/readers/disparity_reader.h"
#include "pipeline/readers/limits.h"
#include "pipeline/readers/photographs/stereo_reader.h"
#include "pipeline/stages/density.h"
#include "pipeline/stages/disparity.h"

namespace hexrelief::config {

inline constexpr double kNotGiven = std::numeric_limits<double>::quiet_NaN();

// NaN = not given. Given values override the file's.
struct CalibrationConfig {
    std::string file = {};         // empty = none
    std::string second_file = {};  // the right camera, or the movement between both; empty = none
    double focal_px = kNotGiven;
    double fov_x_deg = kNotGiven;  // angle of view across the width, instead of focal_px
    double baseline_m = kNotGiven;
    double cx = kNotGiven;  // px from the image's left edge; the centre of the first pixel is 0.5
    double cy = kNotGiven;
    double doffs_px = kNotGiven;
    readers::Rectify rectify = readers::Rectify::automatic;  // applies to pairs
};

// Which pairs are rectified before they are matched: auto = by their calibration file if that says so, and
// without one by their own points if their rows are off; always = by their points; never = none;
// calibration = by the file alone.
enum class PairRectification { automatic, always, never, calibration };

enum class Densification { automatic, off };

struct InputConfig {
    PairRectification rectify = PairRectification::automatic;
    // Turns pictures as their EXIF orientation says; a map's picture only if that makes it fit the map.
    bool exif_orientation = true;
    readers::DisparityFileConfig disparity = {};
    // Applies to supplied maps of disparities or depths (pipeline/stages/densify).
    Densification densify = Densification::automatic;
    readers::DepthFileConfig depth = {};
    readers::MaskConfig mask = {};
    readers::ConfidenceConfig confidence = {};
    CalibrationConfig calibration = {};
    readers::StereoFileConfig stereo = {};
};

enum class BackendChoice { automatic, cpu, cuda };

struct ExecutionConfig {
    BackendChoice backend = BackendChoice::automatic;
    int threads = 0;  // 0 = all threads that the process may use
    // Makes likely mistakes in an input (pipeline/checks) errors instead of warnings.
    bool strict = false;
};

// Limits on a run's cost, for inputs from untrusted sources.
struct LimitsConfig {
    readers::ReaderLimits reading = {};
    long long max_memory = 0;  // bytes, estimated before the work (pipeline/job/run_files.h); 0 = no limit
};

// At most one limit is given; 0 = not given. A limit starts a search for the
// spacing, beginning at mesh.spacing_px.
struct BudgetConfig {
    long long vertices = 0;   // largest number of the surface's vertices
    long long max_bytes = 0;  // largest size of an output with its companion files
    double max_error_px = 0;  // largest error in both views (SurfaceQuality::duo_rmse_near_px)
};

struct Config {
    InputConfig input = {};
    stages::DisparityConfig disparity = {};
    stages::DensityConfig density = {};
    MeshConfig mesh = {};
    SurfaceConfig surface = {};
    exporters::ExportConfig exporting = {};
    BudgetConfig budget = {};
    LimitsConfig limits = {};
    ExecutionConfig run = {};
    std::vector<std::string> decisions = {};  // from reading: choices for values that were not given
    std::set<std::string> given = {};         // keys that a file, a setting or an option gave
};

}  // namespace hexrelief::config
