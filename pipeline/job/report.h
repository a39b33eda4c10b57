// What a run did: the report that --report writes.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/job/backend.h"
#include "pipeline/job/input.h"
#include "pipeline/job/outputs.h"
#include "pipeline/job/picture_shares.h"
#include "pipeline/job/steps.h"

namespace hexrelief::job {

// What a run makes of its input, before anything is written: what its stages gave.
struct Relief {
    RunInput input;
    std::shared_ptr<Backend> backend;
    std::string backend_reason;  // why this one
    DisparityResult disparity;
    DensityMap density;
    SurfaceResult surface;

    // Refers to this.
    LeftView view() const;
};

// And what writing it came to.
struct RunReport {
    std::shared_ptr<const Relief> relief;
    std::string stamp = {};                        // of the request; empty = none
    std::optional<SurfaceMeasures> measures = {};  // only where a report or a page is asked for
    std::vector<SurfaceMesh> coarser = {};         // levels of detail, fine to coarse
    PictureShares shares = {};
    std::vector<OutputFile> outputs = {};
    std::vector<std::pair<std::string, double>> stage_seconds = {};
    std::vector<std::string> warnings = {};
    double seconds = 0;          // from the beginning of the run until its report
    std::size_t peak_bytes = 0;  // of the process's memory until then

    const config::Config& config() const { return relief->surface.config; }  // in effect
};

// A sparse map's, or a pair's.
struct OriginShares {
    double measured = 0, filled = 0;  // of the picture; what is measured of a pair is matched
};
// None where the map was supplied as it is.
std::optional<OriginShares> origin_shares(const DisparityMap& map);

// What share of the picture is meshed, and what became of its pixels. A depth map has no right camera.
PictureShares shares_of(const Relief& relief);

// Time, memory and warnings until now.
void take_figures(const RunLog& log, RunReport& report);

// The report as JSON text, schema 1.
std::string report_json(const RunReport& report);

// What glTF's asset.extras hold: version, parameters and calibration; nothing that differs between machines,
// so that the same input gives the same bytes everywhere.
std::string extras_json(const LeftView& view, const SurfaceResult& result);

}  // namespace hexrelief::job
