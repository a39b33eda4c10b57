// What a run did: the report that --report writes.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mesher/mesher.h"
#include "pipeline/budget/budget.h"
#include "pipeline/config/config.h"
#include "pipeline/data/bounds.h"
#include "pipeline/data/calibration.h"
#include "pipeline/job/input.h"
#include "pipeline/job/outputs.h"
#include "pipeline/job/picture_shares.h"
#include "pipeline/job/steps.h"
#include "pipeline/stages/surface_quality.h"

namespace hexrelief::job {

// A coarser level of detail.
struct LevelReport {
    double spacing_px = 0;
    std::size_t vertices = 0, triangles = 0;
};

// How a pair was matched.
struct MatchingReport {
    stages::DisparityConfig config;              // with the range searched
    double matched_share = 0, filled_share = 0;  // of the image
};

// A sparse map that was filled between its measurements.
struct FillingReport {
    double measured_share = 0, filled_share = 0;  // of the image
};

struct RunReport {
    std::string stamp;  // of the request; empty = none
    std::string backend, backend_reason, device;
    int threads = 0;
    config::Config config;  // effective
    std::vector<InputFile> inputs;
    int width = 0, height = 0;
    Calibration calibration;  // in effect
    InputBeliefs believed;
    double quantum_px = 0;                   // of a supplied map whose steps were smoothed; 0 = none were
    std::optional<FillingReport> filling;    // where the input is a sparse map that was filled
    std::optional<MatchingReport> matching;  // where the input is a pair
    std::vector<std::pair<std::string, double>> stage_seconds;
    int columns = 0, rows = 0;
    std::size_t lattice_triangles = 0;
    int iterations = 0;
    double device_training_s = 0;  // on the device's clock; 0 on the CPU
    double device_balance_s = 0;   // the same for balancing
    double device_surface_s = 0;   // the same for cutting and fitting the mesh
    std::size_t device_bytes = 0;  // device memory in use at the peak; 0 on the CPU
    quality::MeshQuality quality;
    std::size_t vertices = 0, triangles = 0;
    int components = 0, boundary_loops = 0;
    std::vector<LevelReport> levels;  // fine to coarse
    Bounds bounds;
    PictureShares shares;
    stages::SurfaceQuality surface_quality;  // measured only where a report is asked for
    budget::BudgetResult budget;
    std::vector<OutputFile> outputs;
    std::vector<std::string> warnings;
    double seconds = 0;          // from the beginning of the run until its report
    std::size_t peak_bytes = 0;  // of the process's memory until then

    // Of the mesh, along the left camera's axis: metres, or relative units.
    double nearest() const { return -static_cast<double>(bounds.high.z); }
    double farthest() const { return -static_cast<double>(bounds.low.z); }
};

// What the steps of a run came to.
struct RunResults {
    const std::string& backend_reason;
    const RunInput& input;
    const DisparityResult& disparity;
    const LeftView& view;
    const SurfaceResult& result;
    const SurfaceMeasures& measures;
    const std::vector<DetailLevel>& coarser;
    const std::vector<OutputFile>& outputs;
    const PictureShares& shares;
};

// What share of the picture is meshed, and what became of its pixels.
PictureShares shares_of(const LeftView& view, const SurfaceResult& result);

RunReport assemble_report(const RunResults& results, const RunContext& run);

// The report as JSON text, schema 1.
std::string report_json(const RunReport& report);

// What glTF's asset.extras hold: version, parameters and calibration; nothing that differs between machines,
// so that the same input gives the same bytes everywhere.
std::string extras_json(const LeftView& view, const SurfaceResult& result);

}  // namespace hexrelief::job
