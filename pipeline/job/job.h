// One job under way: what its stages hand on, and the steps that the runner takes.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "exporters/exporter.h"
#include "pipeline/job/backend.h"
#include "pipeline/job/runner.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/image.h"
#include "pipeline/data/surface_mesh.h"

namespace hexrelief {

// Everything between the stages of one job.
struct Job {
    RunRequest request;  // a copy: a budget changes its configuration
    const RunObserver& observer;
    Backend backend;
    RunReport report;
    Image texture;  // the left or colour image; empty = none
    DisparityMap map;
    DensityMap density;
    MeshResult solved;
    SurfaceMesh surface;
    std::vector<SurfaceMesh> coarser;  // levels of detail

    // Runs one stage between the observer's calls and notes its time.
    void stage(const std::string& name, const std::function<void()>& work);
    void decide(const std::string& decision) const {
        if (observer.decides) observer.decides(decision);
    }

    void flush_warnings(std::size_t from) const {
        for (std::size_t i = from; i < report.warnings.size() && observer.warns; ++i)
            observer.warns(report.warnings[i]);
    }
};

// "%.3f" and the like.
std::string fixed(double value, int digits);

// Input and disparity: fills map and texture.
void obtain_map(Job& job);
void compute_densities(Job& job);
// Mesh, quality and surface, by the job's configuration as it is.
void make_surface(Job& job);
// Lowers the configured tolerance to what the surface is worth (tolerance.h), where that is asked for.
void settle_tolerance(Job& job);
// Of the 2D mesh.
void warn_of_inversions(Job& job);
// Levels of detail: everything after the map again, at twice the spacing each time.
void make_coarser_levels(Job& job);
// The surface against the map.
void measure_surface(Job& job);

// What is to be written.
Scene scene_of(const Job& job);

bool has_budget(const BudgetConfig& budget);
// make_surface() until the configured budget is met; the configuration then holds what was found. Throws
// Error(usage).
void meet_budget(Job& job);

}  // namespace hexrelief
