// The report of a run, which --report writes.
#pragma once

#include <cstddef>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/job/outputs.h"
#include "pipeline/job/relief.h"
#include "pipeline/stages/other_views/hole_shares.h"
#include "pipeline/stages/surface_quality.h"
#include "pipeline/stages/surface_topology.h"

namespace hexrelief::job {

// A relief and the results of writing it.
struct RunReport {
    std::shared_ptr<const Relief> relief;
    std::string stamp = {};  // the request's; empty = none
    // By take_measures(), only for a report or a page; else 0.
    stages::Topology topology = {};
    stages::SurfaceQuality quality = {};
    stages::HoleShares holes = {};
    std::vector<SurfaceMesh> coarser = {};  // levels of detail, fine to coarse
    PictureShares shares = {};
    std::vector<OutputFile> outputs = {};
    std::vector<std::pair<std::string, double>> stage_seconds = {};
    std::vector<std::string> warnings = {};
    double seconds = 0;          // from the beginning of the run to its report
    std::size_t peak_bytes = 0;  // the process's largest memory until its report

    const config::Config& config() const { return relief->surface.config; }  // in effect
};

nlohmann::ordered_json calibration_json(const Calibration& camera);

// Returns the figures that compare a surface with its map, by their names in the report.
nlohmann::ordered_json surface_figures_json(const stages::SurfaceQuality& quality,
                                            const stages::HoleShares& holes);

// Shares of a filled sparse map or of a matched pair.
struct OriginShares {
    double measured = 0, filled = 0;  // shares of the picture; a pair's matched pixels count as measured
};
// Returns none if the map was supplied and not filled.
std::optional<OriginShares> origin_shares(const DisparityMap& map);

// Returns the picture's shares. A depth map has no right camera, so that its occluded
// pixels count as unknown.
PictureShares shares_of(const Relief& relief);

// Sets the topology of the surface, its holes, and its quality as the outputs hold it.
void take_measures(const std::vector<std::filesystem::path>& outputs, RunReport& report);

// Copies the times, memory and warnings so far into the report.
void take_figures(const RunLog& log, RunReport& report);

// Returns the report as JSON text, schema 1.
std::string report_json(const RunReport& report);

// Returns the JSON text of glTF's asset.extras: version, parameters and calibration. It holds nothing that
// differs between machines, so that the same input gives the same bytes everywhere.
std::string extras_json(const LeftView& view, const SurfaceResult& result);

}  // namespace hexrelief::job
