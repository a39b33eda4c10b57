// The whole configuration: one struct a stage, as YAML's top-level sections.
#pragma once

#include <limits>
#include <set>
#include <string>
#include <vector>

#include "exporters/core/scene.h"
#include "mesher/common/mesh_config.h"
#include "mesher/common/surface_config.h"
#include "pipeline/readers/cameras/stereo_calibration_reader.h"
#include "pipeline/readers/depth/depth_reader.h"
#include "pipeline/readers/depth/mask_reader.h"
#include "pipeline/readers/disparity_reader.h"
#include "pipeline/readers/limits.h"
#include "pipeline/readers/stereo_reader.h"
#include "pipeline/stages/density.h"
#include "pipeline/stages/disparity.h"

namespace hexrelief::config {

inline constexpr double kNotGiven = std::numeric_limits<double>::quiet_NaN();

// NaN = not given. Given values override those of the file.
struct CalibrationConfig {
    std::string file;  // empty = none
    double focal_px = kNotGiven;
    double fov_x_deg = kNotGiven;  // angle of view across the width, in place of focal_px
    double baseline_m = kNotGiven;
    double cx = kNotGiven;  // px from the image's left edge; the centre of the first pixel is 0.5
    double cy = kNotGiven;
    double doffs_px = kNotGiven;
    readers::Rectify rectify = readers::Rectify::automatic;  // of pairs
};

enum class Densification { automatic, off };

struct InputConfig {
    readers::DisparityFileConfig disparity;
    // Of a supplied map, of disparities or of depth (pipeline/densify).
    Densification densify = Densification::automatic;
    readers::DepthFileConfig depth;
    readers::MaskConfig mask;
    readers::ConfidenceConfig confidence;
    CalibrationConfig calibration;
    readers::StereoFileConfig stereo;
};

enum class BackendChoice { automatic, cpu, cuda };

struct ExecutionConfig {
    BackendChoice backend = BackendChoice::automatic;
    int threads = 0;  // 0 = all that the process may use
    // What an input seems to be wrong in (pipeline/checks) is an error instead of a warning.
    bool strict = false;
};

// What a run may cost at most, for inputs that nobody vouches for.
struct LimitsConfig {
    readers::ReaderLimits reading;
    long long max_memory = 0;  // bytes, as estimated before the work (pipeline/job/run_files.h); 0 = no limit
};

// At most one is given; 0 = not given. The spacing is then searched for, beginning at mesh.spacing_px.
struct BudgetConfig {
    long long vertices = 0;   // of the surface, at most
    long long max_bytes = 0;  // of each output with the files beside it, at most
    double max_error_px = 0;  // of both views (SurfaceQuality::duo_rmse_near_px), at most
};

struct Config {
    InputConfig input;
    stages::DisparityConfig disparity;
    stages::DensityConfig density;
    MeshConfig mesh;
    SurfaceConfig surface;
    exporters::ExportConfig exporting;
    BudgetConfig budget;
    LimitsConfig limits;
    ExecutionConfig run;
    std::vector<std::string> warnings;   // from reading: keys given by their old names
    std::vector<std::string> decisions;  // from reading: what was chosen where nothing was given
    std::set<std::string> given;         // paths of the keys that a file, a setting or an option gave
};

}  // namespace hexrelief::config
