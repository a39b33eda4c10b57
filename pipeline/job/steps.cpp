#include "pipeline/job/steps.h"

#include <algorithm>
#include <utility>

#include "pipeline/checks/pair_statistics.h"
#include "pipeline/data/background.h"
#include "pipeline/data/bounds.h"
#include "pipeline/data/error.h"
#include "pipeline/densify/densify.h"
#include "pipeline/densify/sparsity.h"
#include "pipeline/dequantize/dequantize.h"
#include "pipeline/dequantize/quantum.h"
#include "pipeline/job/maps/mask_input.h"
#include "pipeline/job/tolerance.h"
#include "pipeline/stages/sgbm.h"
#include "pipeline/stages/silhouettes.h"
#include "pipeline/stages/surface.h"

namespace hexrelief::job {
namespace {

mesher::MeshResult solve_lattice(const LeftView& view, const MeshConfig& config, const RunContext& run) {
    const mesher::MeshResult solved = run.backend.solve_mesh(
        view.density, view.meshed, config, [&run](double share) { run.log.progress(share); });
    if (solved.device_bytes > 0)
        run.log.decide("device: training " + fixed(solved.device_training_s * 1e3, 3) + " ms, balancing " +
                       fixed(solved.device_balance_s * 1e3, 3) + " ms on its own clock, " +
                       fixed(static_cast<double>(solved.device_bytes) / (1 << 20), 1) + " MiB of its memory");
    run.log.decide("lattice: " + std::to_string(solved.mesh.columns) + " x " +
                   std::to_string(solved.mesh.rows) + ", " + std::to_string(solved.iterations) +
                   " iterations on " + run.backend.name);
    return solved;
}

SpaceSurface surface_of(const mesher::MeshResult& lattice, const LeftView& view, const config::Config& config,
                        const RunContext& run) {
    surface::DisparityMeshResult cut =
        run.backend.cut_disparity_mesh({&lattice.mesh, &view.meshed, view.density.background_px,
                                        view.color.empty() ? nullptr : &view.color, lattice.map_on_device},
                                       config.surface);
    if (cut.device_bytes > 0)
        run.log.decide("device: cut and fit " + fixed(cut.device_s * 1e3, 3) + " ms on its own clock, " +
                       fixed(static_cast<double>(cut.device_bytes) / (1 << 20), 1) + " MiB of its memory");
    stages::adjust_silhouettes(cut.cut_mesh, view.disparity, view.density.background_px,
                               config.surface.silhouette_rounds);
    SurfaceMesh mesh = stages::build_surface(cut.cut_mesh, view.disparity.width, view.disparity.height,
                                             view.calibration, config.surface.min_component);
    const Bounds bounds = bounds_of(mesh.positions);
    return {std::move(mesh), bounds, cut.device_s};
}

SpaceSurface lift(const mesher::MeshResult& lattice, const LeftView& view, const config::Config& config,
                  const RunContext& run) {
    SpaceSurface surface = surface_of(lattice, view, config, run);
    run.log.decide("depth: " + fixed(-surface.bounds.high.z, 3) + " to " + fixed(-surface.bounds.low.z, 3) +
                   (view.calibration.metric ? " m" : " (relative)"));
    return surface;
}

DetailLevel coarser_level(int level, const LeftView& view, const config::Config& config,
                          const RunContext& run) {
    const int levels = config.exporting.lod;
    const auto progress = [&](double share) { run.log.progress((level - 1 + share) / (levels - 1)); };
    try {
        const mesher::MeshResult lattice =
            run.backend.solve_mesh(view.density, view.meshed, config.mesh, progress);
        return {config.mesh.spacing_px, surface_of(lattice, view, config, run).mesh};
    } catch (const Error& error) {
        throw Error(error.kind(), "level of detail " + std::to_string(level) + " at a spacing of " +
                                      fixed(config.mesh.spacing_px, 1) + " px: " + error.what() +
                                      "; or lower export.lod");
    }
}

}  // namespace

int num_disparities_by(const Calibration& calibration, const stages::DisparityConfig& config, int width) {
    const int below_ndisp = calibration.ndisp_px - config.min_disparity_px;
    if (config.num_disparities_px > 0 || calibration.ndisp_px <= 0 || below_ndisp <= 0) return 0;
    return std::min({below_ndisp, width, stages::kLargestRange_px - std::max(0, config.min_disparity_px)});
}

std::string range_text(const stages::DisparityConfig& ranged, checks::RangeOrigin origin) {
    return "disparity: " + std::to_string(ranged.num_disparities_px) + " px searched from " +
           std::to_string(ranged.min_disparity_px) + " px on" +
           (origin == checks::RangeOrigin::ndisp   ? ", by the calibration's ndisp"
            : origin == checks::RangeOrigin::given ? ""
                                                   : ", chosen from the pair") +
           (ranged.farthest_px > ranged.min_disparity_px
                ? ", no small patch below " + fixed(ranged.farthest_px, 1) + " px"
                : "");
}

ChosenRange choose_range(const StereoPair& pair, const Calibration& calibration,
                         const stages::DisparityConfig& config, int threads, const RunLog& log) {
    stages::DisparityConfig said = config;
    const int by_calibration = num_disparities_by(calibration, config, pair.left.width);
    if (by_calibration > 0) said.num_disparities_px = by_calibration;
    stages::RangedPair ranged = stages::find_range(pair, said, threads);
    const checks::RangeOrigin origin = by_calibration > 0              ? checks::RangeOrigin::ndisp
                                       : config.num_disparities_px > 0 ? checks::RangeOrigin::given
                                                                       : checks::RangeOrigin::chosen;
    log.decide(range_text(ranged.config, origin));
    StereoPair in_one_light = stages::corrected(pair, ranged.correction, threads);
    return {std::move(ranged), std::move(in_one_light), origin};
}

void check_detail(bool is_left_blank, bool is_right_blank) {
    if (is_left_blank || is_right_blank)
        throw Error(ErrorKind::input, std::string("nothing matched: the ") +
                                          (is_left_blank ? "left" : "right") +
                                          " picture is blank, one colour everywhere; check the file");
}

void check_matches(bool has_any) {
    if (!has_any)
        throw Error(
            ErrorKind::input,
            "nothing matched: no point of the left picture was found in the right one; check that they "
            "are two views of one scene, rectified and not blank");
}

DisparityResult match_input(const StereoPair& pair, const ChosenRange& range, const RunContext& run) {
    check_detail(checks::is_blank(pair.left), checks::is_blank(pair.right));
    DisparityResult result{
        stages::match_in_range(range.corrected, range.config, run.backend.match_pair, run.threads), true,
        range.config};
    const std::vector<PixelOrigin>& origins = result.map.origins;
    check_matches(std::find(origins.begin(), origins.end(), PixelOrigin::matched) != origins.end());
    return result;
}

void count_from_infinity(DisparityResult& disparity, Calibration& calibration, const RunLog& log) {
    const auto is_far = [](float d) { return DisparityMap::known(d) && d <= 0; };
    const std::vector<float>& values = disparity.map.values;
    if (calibration.doffs_px <= 0 || std::none_of(values.begin(), values.end(), is_far)) return;
    for (DisparityMap* map : {&disparity.map, &disparity.smooth})
        for (float& d : map->values)
            if (DisparityMap::known(d)) d += static_cast<float>(calibration.doffs_px);
    log.decide("disparity: some are 0 or less; the calibration's doffs of " + fixed(calibration.doffs_px, 2) +
               " px is added to all");
    calibration.doffs_px = 0;
}

DisparityMap densify_input(DisparityMap map, const Image& left, const readers::PixelMask& mask,
                           const config::Config& config, const RunContext& run) {
    if (config.input.densify == config::Densification::off) return map;
    const densify::Sparsity sparsity = densify::measure_sparsity(map);
    if (!sparsity.is_sparse()) return map;
    DisparityMap dense = run.log.stage("densify", [&] {
        DisparityMap filled = densify::densify(map, left, run.threads);
        hide(filled, mask);
        return filled;
    });
    const auto percent = [](double share) { return fixed(100 * share, 1) + " %"; };
    run.log.decide("densify: " + percent(sparsity.known_share) +
                   " of the pixels are known, with unknown ones between them; " +
                   percent(densify::measure_sparsity(dense).known_share) + " are known when filled" +
                   (left.empty() ? "" : ", by the picture's colours"));
    return dense;
}

DisparityResult smooth_input(DisparityMap map, const config::Config& config, const RunContext& run) {
    DisparityResult result{std::move(map), false, {}};
    if (config.disparity.dequantize == stages::Dequantization::none) return result;
    const double quantum_px = dequantize::find_quantum_px(result.map);
    const double max_error_px = config.budget.max_error_px;
    if (quantum_px == 0 || (max_error_px > 0 && max_error_px < quantum_px)) return result;
    result.quantum_px = quantum_px;
    result.smooth = dequantize::dequantize(result.map, quantum_px, run.threads);
    run.log.decide("disparity: smoothed within its steps of " + fixed(quantum_px, 3) + " px");
    return result;
}

DensityMap density_of(const DisparityMap& disparity, const stages::DensityConfig& config, int threads,
                      const RunLog& log) {
    DensityMap density = stages::compute_density(disparity, config, threads);
    const auto kept = std::count_if(disparity.values.begin(), disparity.values.end(), [&](float d) {
        return DisparityMap::known(d) && d > 0 && d >= density.background_px;
    });
    if (kept == 0)
        throw Error(ErrorKind::input,
                    "nothing is left to mesh: no known disparity above the background threshold of " +
                        fixed(density.background_px, 2) +
                        " px; check the input or lower density.background.fraction");
    log.decide((density.background_px > 0 ? "background: below " + fixed(density.background_px, 2) + " px; "
                                          : std::string("background: nothing is removed; ")) +
               fixed(100.0 * static_cast<double>(kept) / static_cast<double>(density.values.size()), 1) +
               " % of the image is foreground");
    return density;
}

SurfaceResult make_surface(const LeftView& view, const config::Config& config, const RunContext& run) {
    SurfaceResult result;
    result.lattice = run.log.stage("mesh", [&] { return solve_lattice(view, config.mesh, run); });
    auto quality = start_work(run.threads, [&] {
        return quality::measure_quality(result.lattice.mesh, view.density, run.threads);
    });
    result.surface = run.log.stage("surface", [&] { return lift(result.lattice, view, config, run); });
    result.quality = run.log.stage("quality", [&] { return quality.get(); });
    result.config = config;
    if (config.exporting.tolerance_share > 0)
        result.config = run.log.stage("tolerance",
                                      [&] { return with_tolerance(config, result.surface.mesh, view, run); });
    return result;
}

config::Config with_tolerance(const config::Config& config, const SurfaceMesh& surface, const LeftView& view,
                              const RunContext& run) {
    config::Config effective = config;
    if (!(config.exporting.tolerance_share > 0)) return effective;
    effective.exporting.tolerance_px =
        tolerance_for(config.exporting, surface, view.disparity, view.density.background_px, run.threads);
    run.log.decide("tolerance: " + fixed(effective.exporting.tolerance_px, 3) + " px");
    return effective;
}

void warn_of_inversions(const quality::MeshQuality& quality, RunLog& log) {
    if (quality.inverted_triangles > 0)
        log.warn(std::to_string(quality.inverted_triangles) +
                 " triangles of the 2D mesh are inverted; more iterations (mesh.t_max) may help");
}

std::vector<DetailLevel> coarser_levels(const LeftView& view, const config::Config& config,
                                        const RunContext& run) {
    std::vector<DetailLevel> levels;
    config::Config coarser = config;
    for (int level = 1; level < config.exporting.lod; ++level) {
        coarser.mesh.spacing_px *= 2;
        levels.push_back(coarser_level(level, view, coarser, run));
        const SurfaceMesh& mesh = levels.back().mesh;
        run.log.decide("level of detail " + std::to_string(level) + ": " + fixed(coarser.mesh.spacing_px, 1) +
                       " px, " + std::to_string(mesh.positions.size()) + " vertices, " +
                       std::to_string(mesh.triangles.size()) + " triangles");
    }
    return levels;
}

SurfaceMeasures measure_surface(const SurfaceMesh& surface, const SurfaceMesh& written, const LeftView& view,
                                const RunContext& run) {
    const SurfaceMeasures measures = {
        stages::count_topology(surface),
        stages::measure_surface_quality(written, view.disparity, view.density.background_px, run.threads)};
    const stages::SurfaceQuality& quality = measures.quality;
    run.log.decide(
        "root mean square error against the disparity map: left view " + fixed(quality.rmse_near_px, 3) +
        " px, both views " + fixed(quality.duo_rmse_near_px, 3) + " px, away from discontinuities " +
        fixed(quality.flat_rmse_px, 3) + " px; rubber sheets over " + fixed(100 * quality.sheet_share, 2) +
        " % of what only the right camera sees, coverage " + fixed(100 * quality.coverage, 2) + " %");
    return measures;
}

}  // namespace hexrelief::job
