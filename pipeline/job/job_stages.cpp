#include <algorithm>
#include <cstdio>
#include <limits>

#include "mesher/surface/disparity_mesh.h"
#include "pipeline/data/clock.h"
#include "pipeline/data/error.h"
#include "pipeline/job/interrupt.h"
#include "pipeline/job/job.h"
#include "pipeline/job/resolve_calibration.h"
#include "pipeline/job/sha256.h"
#include "pipeline/job/tolerance.h"
#include "pipeline/readers/disparity_reader.h"
#include "pipeline/readers/image_reader.h"
#include "pipeline/stages/relief_quality.h"
#include "pipeline/stages/surface_topology.h"

namespace hexrelief {
namespace {

namespace fs = std::filesystem;

std::string size_text(int width, int height) {
    return std::to_string(width) + "x" + std::to_string(height);
}

void hash_input(Job& job, const std::string& role, const fs::path& path) {
    job.report.inputs.push_back({role, path.string(), sha256_of_file(path)});
}

void read_pair(Job& job, StereoPair& pair) {
    pair.left = read_image(job.request.left);
    pair.right = read_image(job.request.right);
    if (pair.left.width != pair.right.width || pair.left.height != pair.right.height)
        throw Error(ErrorKind::input, "the pair's sizes differ: " + job.request.left.string() + " has " +
                                          size_text(pair.left.width, pair.left.height) + " px, " +
                                          job.request.right.string() + " " +
                                          size_text(pair.right.width, pair.right.height) +
                                          "; rectified images have one size");
    hash_input(job, "left", job.request.left);
    hash_input(job, "right", job.request.right);
}

void read_map(Job& job) {
    job.map = read_disparity_map(job.request.disparity, job.request.config.input.disparity);
    hash_input(job, "disparity", job.request.disparity);
    if (job.request.color.empty()) return;
    job.texture = read_image(job.request.color);
    if (job.texture.width != job.map.width || job.texture.height != job.map.height)
        throw Error(ErrorKind::input, job.request.color.string() + ": the colour image has " +
                                          size_text(job.texture.width, job.texture.height) +
                                          " px, but the map " + job.request.disparity.string() + " has " +
                                          size_text(job.map.width, job.map.height) +
                                          "; both must show the left view");
    hash_input(job, "color", job.request.color);
}

void find_camera(Job& job, int width, int height) {
    const CalibrationConfig& config = job.request.config.input.calibration;
    const std::size_t told = job.report.warnings.size();
    job.report.width = width;
    job.report.height = height;
    job.report.calibration = resolve_calibration(config, width, height, job.report.warnings);
    if (!config.file.empty()) hash_input(job, "calibration", config.file);
    job.flush_warnings(told);
    const Calibration& camera = job.report.calibration;
    job.decide("calibration: focal " + fixed(camera.focal_px, 2) + " px, baseline " +
               fixed(camera.baseline_m, 4) + (camera.metric ? " m" : " (relative)") + ", principal point (" +
               fixed(camera.cx, 2) + ", " + fixed(camera.cy, 2) + "), doffs " + fixed(camera.doffs_px, 2) +
               " px");
}

void solve_mesh(Job& job) {
    const auto progress = [&job](double share) {
        wait_if_interrupted();
        if (job.observer.stage_progresses) job.observer.stage_progresses(share);
    };
    job.solved = job.backend.solve_mesh(job.density, job.map, job.request.config.mesh, progress);
    RunReport& report = job.report;
    report.columns = job.solved.mesh.columns;
    report.rows = job.solved.mesh.rows;
    report.lattice_triangles = job.solved.mesh.triangle_count();
    report.iterations = job.solved.iterations;
    report.device_training_s = job.solved.device_training_s;
    report.device_balance_s = job.solved.device_balance_s;
    report.device_bytes = job.solved.device_bytes;
    if (job.solved.device_bytes > 0)
        job.decide("device: training " + fixed(job.solved.device_training_s * 1e3, 3) + " ms, balancing " +
                   fixed(job.solved.device_balance_s * 1e3, 3) + " ms on its own clock, " +
                   fixed(static_cast<double>(job.solved.device_bytes) / (1 << 20), 1) + " MiB of its memory");
    job.decide("lattice: " + std::to_string(report.columns) + " x " + std::to_string(report.rows) + ", " +
               std::to_string(report.iterations) + " iterations on " + job.backend.name);
}

void measure(Job& job) {
    job.report.quality = measure_quality(job.solved.mesh, job.density, job.report.threads);
}

SurfaceMesh surface_of(Job& job, const MeshResult& solved) {
    const Config& config = job.request.config;
    const DisparityMeshResult opened =
        job.backend.cut_disparity_mesh({&solved.mesh, &job.map, job.density.background_px,
                                        job.texture.empty() ? nullptr : &job.texture, solved.map_on_device},
                                       config.cut_mesh);
    job.report.device_surface_s = opened.device_s;
    if (opened.device_bytes > 0)
        job.decide("device: sheet " + fixed(opened.device_s * 1e3, 3) + " ms on its own clock, " +
                   fixed(static_cast<double>(opened.device_bytes) / (1 << 20), 1) + " MiB of its memory");
    return build_surface(opened.cut_mesh, job.map.width, job.map.height, job.report.calibration,
                         config.surface);
}

void lift(Job& job) {
    job.surface = surface_of(job, job.solved);
    RunReport& report = job.report;
    report.vertices = job.surface.positions.size();
    report.triangles = job.surface.triangles.size();
    constexpr float far = std::numeric_limits<float>::max();
    report.lower = {far, far, far};
    report.upper = {-far, -far, -far};
    for (const Vec3f& p : job.surface.positions) {
        report.lower = {std::min(report.lower.x, p.x), std::min(report.lower.y, p.y),
                        std::min(report.lower.z, p.z)};
        report.upper = {std::max(report.upper.x, p.x), std::max(report.upper.y, p.y),
                        std::max(report.upper.z, p.z)};
    }
    job.decide("depth: " + fixed(-report.upper.z, 3) + " to " + fixed(-report.lower.z, 3) +
               (report.calibration.metric ? " m" : " (relative)"));
}

}  // namespace

std::string fixed(double value, int digits) {
    char buffer[64];
    std::snprintf(buffer, sizeof buffer, "%.*f", digits, value);
    return buffer;
}

void Job::stage(const std::string& name, const std::function<void()>& work) {
    wait_if_interrupted();
    if (observer.stage_begins) observer.stage_begins(name);
    const double begun = now_seconds();
    work();
    const double seconds = now_seconds() - begun;
    if (observer.stage_ends) observer.stage_ends(name, seconds);
    // A budget comes to the same stage several times.
    for (auto& [known, sum] : report.stage_seconds)
        if (known == name) {
            sum += seconds;
            return;
        }
    report.stage_seconds.emplace_back(name, seconds);
}

// Input and disparity: fills map and texture.
void obtain_map(Job& job) {
    const bool matching = job.request.disparity.empty();
    StereoPair pair;
    job.stage("input", [&] {
        if (matching)
            read_pair(job, pair);
        else
            read_map(job);
        const int width = matching ? pair.left.width : job.map.width,
                  height = matching ? pair.left.height : job.map.height;
        find_camera(job, width, height);
    });
    if (matching) {
        job.stage("disparity", [&] {
            job.map = compute_disparity(pair, job.request.config.disparity, job.report.threads);
        });
        job.texture = std::move(pair.left);
    }
}

void compute_densities(Job& job) {
    job.density = compute_density(job.map, job.request.config.density);
    if (std::none_of(job.density.values.begin(), job.density.values.end(), [](float v) { return v > 0; }))
        throw Error(ErrorKind::input,
                    "nothing is left to mesh: no known disparity above the background threshold of " +
                        fixed(job.density.background_px, 2) +
                        " px; check the input or lower density.background");
    const auto kept =
        std::count_if(job.density.values.begin(), job.density.values.end(), [](float v) { return v > 0; });
    job.decide("background: below " + fixed(job.density.background_px, 2) + " px; " +
               fixed(100.0 * static_cast<double>(kept) / static_cast<double>(job.density.values.size()), 1) +
               " % of the image is foreground");
}

void warn_of_inversions(Job& job) {
    if (job.report.quality.inverted_triangles == 0) return;
    job.report.warnings.push_back(
        std::to_string(job.report.quality.inverted_triangles) +
        " triangles of the 2D mesh are inverted; more iterations (mesh.t_max) may help");
    job.flush_warnings(job.report.warnings.size() - 1);
}

// Takes as long as a good part of the surface stage: only for a report.
void measure_surface(Job& job) {
    const Topology topology = count_topology(job.surface);
    job.report.components = topology.components;
    job.report.boundary_loops = topology.boundary_loops;
    job.report.relief = measure_relief(job.surface, job.map, job.density.background_px, job.report.threads);
    const ReliefQuality& relief = job.report.relief;
    job.decide("against the disparity map: near rmse " + fixed(relief.rmse_near_px, 3) + " px, duo " +
               fixed(relief.duo_rmse_near_px, 3) + " px, flat " + fixed(relief.flat_rmse_px, 3) +
               " px, sheet " + fixed(100 * relief.sheet_share, 2) + " %, coverage " +
               fixed(100 * relief.coverage, 2) + " %");
}

void make_surface(Job& job) {
    job.stage("mesh", [&] { solve_mesh(job); });
    job.stage("quality", [&] { measure(job); });
    job.stage("surface", [&] { lift(job); });
    if (job.request.config.exporting.tolerance_share > 0)
        job.stage("tolerance", [&] { settle_tolerance(job); });
}

void settle_tolerance(Job& job) {
    ExportConfig& config = job.request.config.exporting;
    if (!(config.tolerance_share > 0)) return;
    config.tolerance_px =
        tolerance_for(config, job.surface, job.map, job.density.background_px, job.report.threads);
    job.report.config.exporting.tolerance_px = config.tolerance_px;
    job.decide("tolerance: " + fixed(config.tolerance_px, 3) + " px");
}

void make_coarser_levels(Job& job) {
    const int levels = job.request.config.exporting.lod;
    job.coarser.clear();
    job.report.levels.clear();
    MeshConfig config = job.request.config.mesh;
    for (int level = 1; level < levels; ++level) {
        config.spacing_px *= 2;
        try {
            const auto progress = [&](double share) {
                wait_if_interrupted();
                if (job.observer.stage_progresses)
                    job.observer.stage_progresses((level - 1 + share) / (levels - 1));
            };
            job.coarser.push_back(
                surface_of(job, job.backend.solve_mesh(job.density, job.map, config, progress)));
        } catch (const Error& error) {
            throw Error(error.kind(), "level of detail " + std::to_string(level) + " at a spacing of " +
                                          fixed(config.spacing_px, 1) + " px: " + error.what() +
                                          "; or lower export.lod");
        }
        const SurfaceMesh& mesh = job.coarser.back();
        job.report.levels.push_back({config.spacing_px, mesh.positions.size(), mesh.triangles.size()});
        job.decide("level of detail " + std::to_string(level) + ": " + fixed(config.spacing_px, 1) + " px, " +
                   std::to_string(mesh.positions.size()) + " vertices, " +
                   std::to_string(mesh.triangles.size()) + " triangles");
    }
}

}  // namespace hexrelief
