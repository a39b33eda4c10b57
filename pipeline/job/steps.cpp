#include "pipeline/job/steps.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "pipeline/checks/pair_statistics.h"
#include "pipeline/checks/thresholds.h"
#include "pipeline/data/bounds.h"
#include "pipeline/data/error.h"
#include "pipeline/data/start_work.h"
#include "pipeline/job/maps/fit_map.h"
#include "pipeline/job/matchers/given_maps.h"
#include "pipeline/job/other_views.h"
#include "pipeline/job/pairs/align_pair.h"
#include "pipeline/job/tolerance.h"
#include "pipeline/stages/densify/blurred_steps.h"
#include "pipeline/stages/densify/densify.h"
#include "pipeline/stages/densify/measurements.h"
#include "pipeline/stages/dequantize/dequantize.h"
#include "pipeline/stages/dequantize/mixed_pixels.h"
#include "pipeline/stages/dequantize/noise.h"
#include "pipeline/stages/join_crumbs.h"
#include "pipeline/stages/sgbm.h"
#include "pipeline/stages/silhouettes.h"
#include "pipeline/stages/surface.h"

namespace hexrelief::job {
namespace {

constexpr double kMostUnknown = 0.25;  // share of a map that has holes, and is not a thing cut out

void check_any_match(const DisparityMap& map) {
    check_matches(std::find(map.origins.begin(), map.origins.end(), PixelOrigin::matched) !=
                  map.origins.end());
}

std::string memory_text(const DeviceFigures& device) {
    return fixed(static_cast<double>(device.bytes) / (1 << 20), 1) + " MiB of its memory";
}

HexMesh2D solve_lattice(const LeftView& view, const MeshConfig& config, Backend& backend, const RunLog& log) {
    backend.expect_map(view.meshed);
    HexMesh2D lattice =
        backend.solve_mesh(view.density, config, [&log](double share) { log.progress(share); });
    const DeviceFigures device = backend.figures();
    if (device.bytes > 0)
        log.decide("device: training " + fixed(device.training_s * 1e3, 3) + " ms, balancing " +
                   fixed(device.balance_s * 1e3, 3) + " ms on its own clock, " + memory_text(device));
    log.decide("lattice: " + std::to_string(lattice.columns) + " x " + std::to_string(lattice.rows) + ", " +
               std::to_string(lattice.iterations) + " iterations on " + backend.name());
    return lattice;
}

SurfaceMesh coarser_level(int level, const LeftView& view, const config::Config& config,
                          const SurfaceResult& finest, Backend& backend, const RunLog& log) {
    const int levels = config.exporting.lod;
    const auto progress = [&](double share) { log.progress((level - 1 + share) / (levels - 1)); };
    try {
        backend.expect_map(view.meshed);
        const HexMesh2D lattice = backend.solve_mesh(view.density, config.mesh, progress);
        SurfaceMesh mesh =
            surface_of(cut_lattice(lattice, view, config.surface, backend, log), view, config.surface);
        add_other_views(mesh, finest, view, config, backend, log);
        return mesh;
    } catch (const Error& error) {
        throw Error(error.kind(), "level of detail " + std::to_string(level) + " at a spacing of " +
                                      fixed(config.mesh.spacing_px, 1) + " px: " + error.what() +
                                      "; or lower export.lod");
    }
}

}  // namespace

DisparityMesh cut_lattice(const HexMesh2D& lattice, const LeftView& view, const SurfaceConfig& config,
                          Backend& backend, const RunLog& log) {
    const float background_px = view.density.background_px;
    DisparityMesh cut = backend.cut_disparity_mesh({&lattice, &view.meshed, background_px}, config);
    const DeviceFigures device = backend.figures();
    if (device.surface_s > 0)
        log.decide("device: cut and fit " + fixed(device.surface_s * 1e3, 3) + " ms on its own clock, " +
                   memory_text(device));
    stages::adjust_silhouettes(cut, view.disparity, background_px, config.silhouette_rounds);
    stages::join_crumbs(cut, static_cast<double>(view.meshed.values.size()) / lattice.positions.size());
    // Planes are fitted beyond their pixels.
    for (float& d : cut.disparities) d = std::max(d, view.least_px);
    return cut;
}

SurfaceMesh surface_of(const DisparityMesh& cut_mesh, const LeftView& view, const SurfaceConfig& config) {
    const int width = view.disparity.width, height = view.disparity.height;
    SurfaceMesh mesh = stages::build_surface(cut_mesh, width, height, view.calibration, config.min_component);
    if (view.is_uneven()) stages::smooth_normals(mesh, view.calibration, view.quantum_px);
    return mesh;
}

std::string range_text(const stages::DisparityConfig& searched, stages::RangeOrigin origin) {
    return "disparity: " + std::to_string(searched.num_disparities_px) + " px searched from " +
           std::to_string(searched.min_disparity_px) + " px on" +
           (origin == stages::RangeOrigin::ndisp   ? ", by the calibration's ndisp"
            : origin == stages::RangeOrigin::given ? ""
                                                   : ", chosen from the pair") +
           (searched.farthest_px > searched.min_disparity_px
                ? ", no small patch below " + fixed(searched.farthest_px, 1) + " px"
                : "");
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

DisparityResult disparities_of_pair(const StereoPair& pair, const StereoPair& corrected,
                                    const stages::DisparityConfig& searched, Backend& backend) {
    check_detail(checks::is_blank(pair.left), checks::is_blank(pair.right));
    DisparityResult result{stages::match_range(corrected, searched, backend, backend.threads()), searched};
    check_any_match(result.map);
    return result;
}

DisparityResult disparities_of_program(const StereoPair& pair, const stages::ViewMaps& maps,
                                       const stages::DisparityConfig& config, int threads) {
    check_detail(checks::is_blank(pair.left), checks::is_blank(pair.right));
    DisparityResult result{refine_given(pair, maps, config, threads), config};
    check_any_match(result.map);
    return result;
}

DisparityMap sharpen_map(DisparityMap map, const Image& left, int threads, const RunLog& log) {
    stages::SharpenedMap sharp = stages::sharpen_steps(std::move(map), left, threads);
    if (sharp.blurred_share > 0)
        log.decide("disparity: steps are blurred; " + fixed(100 * sharp.blurred_share, 1) +
                   " % of the pixels lie on them, and are cut along the picture's edges");
    return std::move(sharp.map);
}

void sharpen_maps(stages::ViewMaps& maps, const StereoPair& pair, int threads, const RunLog& log) {
    if (!maps.is_dense) return;
    maps.left = sharpen_map(std::move(maps.left), pair.left, threads, log);
    maps.right = stages::sharpen_steps(std::move(maps.right), pair.right, threads).map;
}

DisparityMap check_map(DisparityMap map, StereoPair pair, const stages::DisparityConfig& config, int threads,
                       RunLog& log) {
    constexpr double another_scene = 0.2;  // faulty maps have up to 0.13, wrong pictures 0.28 and more
    PictureCheck check =
        log.stage("check", [&] { return check_by_picture(std::move(pair), map, config, threads); });
    const std::string share = fixed(100 * check.unlike_share, 1) + " %";
    if (check.unlike_share > another_scene) {
        log.warn(
            share +
            " of the map's pixels have another colour in the right picture, so that is not looked at; check "
            "that --color-right is the right camera's picture, rectified with the left one");
        return map;
    }
    log.decide(
        "disparity: " + share +
        " of the pixels have another colour in the right picture; where the map is at fault, it is filled");
    return std::move(check.map);
}

void judge_support(DisparityResult& disparity, const Image& left, const readers::PixelMask& mask, bool strict,
                   RunLog& log) {
    disparity.support = checks::measure_support(left, disparity.map, mask.kept);
    const std::string agreed = checks::percent(disparity.support);
    log.decide("disparity: both views agree on " + agreed + " of what has texture: support is " +
               checks::support_word(disparity.support));
    if (!checks::is_hardly_supported(disparity.support)) return;
    const std::string text = "the pair hardly supports the mesh: both views agree on only " + agreed +
                             " of what has texture; check that nothing moved between the pictures and that "
                             "their rows are aligned";
    if (strict) throw Error(ErrorKind::input, text);
    log.warn(text);
}

void end_scene(DisparityResult& disparity, const Calibration& calibration, const SurfaceConfig& config,
               const RunLog& log) {
    if (!disparity.matched || config.farthest == 0) return;
    disparity.backdrop = stages::put_backdrop(disparity.map, disparity.matched->min_disparity_px,
                                              calibration.doffs_px, config.farthest);
    if (disparity.backdrop)
        log.decide("disparity: the backdrop is at " + fixed(disparity.backdrop->disparity_px, 2) + " px; " +
                   fixed(100 * disparity.backdrop->moved_share, 1) + " % seemed farther");
}

void press_near(DisparityResult& disparity, double nearest_px, const RunLog& log) {
    const std::size_t moved = stages::press_near(disparity.map, nearest_px);
    if (moved > 0)
        log.decide("disparity: " + std::to_string(moved) + " px seemed nearer than the " +
                   fixed(nearest_px, 2) + " px that matches support, and lie where their surroundings do");
}

void count_from_infinity(DisparityResult& disparity, Calibration& calibration, bool always,
                         const RunLog& log) {
    const auto is_far = [](float d) { return DisparityMap::known(d) && d <= 0; };
    const std::vector<float>& values = disparity.map.values;
    if (calibration.doffs_px <= 0 || (!always && std::none_of(values.begin(), values.end(), is_far))) return;
    for (DisparityMap* map : {&disparity.map, &disparity.smooth})
        for (float& d : map->values)
            if (DisparityMap::known(d)) d += static_cast<float>(calibration.doffs_px);
    if (disparity.backdrop) disparity.backdrop->disparity_px += static_cast<float>(calibration.doffs_px);
    log.decide(std::string("disparity: ") + (always ? "" : "some are 0 or less; ") +
               "the calibration's doffs of " + fixed(calibration.doffs_px, 2) + " px is added to all");
    calibration.doffs_px = 0;
}

double baselines_of_turn(const DisparityMap& map, const Calibration& camera, bool of_photographs) {
    const double tangent = of_photographs ? 0.577 : 0.364, most = 8;  // as many as surface.behind takes
    constexpr std::size_t kEvery = 13;                                // pixels; a sample tells the median
    std::vector<float> known;
    for (std::size_t i = 0; i < map.values.size(); i += kEvery)
        if (DisparityMap::known(map.values[i])) known.push_back(map.values[i]);
    if (known.empty()) return 1;
    const auto middle = known.begin() + static_cast<std::ptrdiff_t>(known.size() / 2);
    std::nth_element(known.begin(), middle, known.end());
    const double from_infinity_px = std::max(*middle + camera.doffs_px, 1e-3);
    return std::clamp(std::round(10 * tangent * camera.focal_px / from_infinity_px) / 10, 1.0, most);
}

DisparityMap densify_map(DisparityMap map, const Image& left, const readers::PixelMask& mask, int threads,
                         RunLog& log) {
    const stages::Sparsity sparsity = stages::measure_sparsity(map);
    if (!sparsity.is_sparse()) return map;
    DisparityMap dense = log.stage("densify", [&] {
        DisparityMap filled = stages::densify(map, left, threads);
        hide(filled, mask);
        return filled;
    });
    const auto percent = [](double share) { return fixed(100 * share, 1) + " %"; };
    log.decide("densify: " + percent(sparsity.known_share) +
               " of the pixels are known, with unknown ones between them; " +
               percent(stages::measure_sparsity(dense).known_share) + " are known when filled" +
               (left.empty() ? "" : ", by the picture's colours"));
    return dense;
}

DisparityResult smooth_map(DisparityMap map, double max_error_px, int threads, const RunLog& log) {
    DisparityResult result{std::move(map), std::nullopt};
    const double quantum_px = stages::find_quantum_px(result.map);
    if (quantum_px == 0 || (max_error_px > 0 && max_error_px < quantum_px)) return result;
    result.quantum_px = quantum_px;
    result.smooth = stages::dequantize(result.map, quantum_px, threads);
    log.decide("disparity: smoothed within its steps of " + fixed(quantum_px, 3) + " px");
    return result;
}

void fill_map(DisparityResult& disparity, const Image& left, const readers::PixelMask& mask, int threads,
              const RunLog& log) {
    const DisparityMap& meshed = disparity.meshed();
    std::size_t unknown = 0, all = 0;
    for (std::size_t i = 0; i < meshed.values.size(); ++i)
        if (mask.empty() || mask.kept[i]) ++all, unknown += !DisparityMap::known(meshed.values[i]);
    if (left.empty() || unknown == 0 ||
        static_cast<double>(unknown) > kMostUnknown * static_cast<double>(all))
        return;
    DisparityMap filled = stages::fill_holes(meshed, left, threads);
    hide(filled, mask);
    std::vector<PixelOrigin>& origins = disparity.map.origins;
    disparity.has_filled_holes = origins.empty();
    if (origins.empty()) origins = filled.origins;
    for (std::size_t i = 0; i < origins.size(); ++i) {
        if (filled.origins[i] != PixelOrigin::filled) continue;
        origins[i] = PixelOrigin::filled;
        disparity.map.values[i] = filled.values[i];
        if (disparity.quantum_px > 0) disparity.smooth.values[i] = filled.values[i];
    }
    log.decide("disparity: " + fixed(100 * static_cast<double>(unknown) / static_cast<double>(all), 1) +
               " % were unknown, and lie on the planes around them");
}

void refine_noisy(DisparityResult& disparity, const InputPair& pair, int threads, const RunLog& log) {
    if (!disparity.matched || !has_camera_of_points(*pair.alignment)) return;
    const auto noise = stages::smoothing_for(
        stages::find_noise_px(disparity.map),
        pair.alignment->is_relief() ? stages::kLeastNoiseOfRelief_px : stages::kLeastNoise_px);
    if (noise.noise_px > 0) disparity.map = stages::refine_by_pictures(disparity.map, pair.views, threads);
    disparity.map =
        stages::without_mixed_pixels(std::move(disparity.map), pair.views.left, stages::Scraps::go);
    if (noise.noise_px == 0) return;
    disparity.noise = noise;
    log.decide("disparity: refined by the pictures, as its noise was " + fixed(noise.noise_px, 3) + " px");
}

void flatten_relief(const DisparityResult& disparity, const InputPair& pair, Calibration& camera,
                    const RunLog& log) {
    const ReliefMap relief{disparity.map, disparity.noise.noise_px, pair.reduced_by};
    const double before_px = std::exchange(camera, flattened(camera, *pair.alignment, relief)).doffs_px;
    if (camera.doffs_px == before_px) return;
    log.decide("disparity: deeper than matches or noise let, so infinity is taken to be at " +
               fixed(-camera.doffs_px, 2) + " px");
}

void smooth_noise(DisparityResult& disparity, int threads, const RunLog& log) {
    if (!disparity.matched || disparity.noise.noise_px > 0) return;
    const auto noise = stages::smoothing_for(stages::find_noise_px(disparity.map));
    if (noise.noise_px == 0) return;
    disparity.noise = noise;
    disparity.map = stages::dequantize(disparity.map, noise.quantum_px, threads);
    log.decide("disparity: smoothed within its noise of " + fixed(noise.noise_px, 3) + " px");
}

DensityMap density_of(const DisparityMap& disparity, const stages::DensityConfig& config, int threads,
                      RunLog& log) {
    DensityMap density = stages::compute_density(disparity, config, threads);
    const auto count_of = [&](const auto& counted) {
        return std::count_if(disparity.values.begin(), disparity.values.end(),
                             [&](float d) { return DisparityMap::known(d) && counted(d); });
    };
    const auto kept = count_of([&](float d) { return d > 0 && d >= density.background_px; });
    if (kept == 0)
        throw Error(ErrorKind::input,
                    "nothing is left to mesh: no known disparity above the background threshold of " +
                        fixed(density.background_px, 2) +
                        " px; check the input or lower density.background.fraction");
    log.decide((density.background_px > 0 ? "background: below " + fixed(density.background_px, 2) + " px; "
                                          : std::string("background: nothing is removed; ")) +
               fixed(100.0 * static_cast<double>(kept) / static_cast<double>(density.values.size()), 1) +
               " % of the image is foreground");
    const auto gone = count_of([&](float d) { return d < density.background_px; });
    if (config.background_method == stages::BackgroundMethod::automatic && gone > kept)
        log.warn("more goes as background than stays, " +
                 checks::percent(static_cast<double>(gone) / static_cast<double>(gone + kept)) +
                 " of what is known: all that lies farther than " + fixed(1 / config.background_fraction, 1) +
                 " times the nearest; set density.background.method=none to keep it");
    return density;
}

SurfaceResult make_surface(const LeftView& view, const config::Config& config, Backend& backend,
                           RunLog& log) {
    const int threads = backend.threads();
    SurfaceResult result;
    result.lattice = log.stage("mesh", [&] { return solve_lattice(view, config.mesh, backend, log); });
    const HexMesh2D& lattice = result.lattice;
    auto quality =
        start_work(threads, [&] { return quality::measure_quality(lattice, view.density, threads); });
    log.stage("surface", [&] {
        const DisparityMesh cut = cut_lattice(lattice, view, config.surface, backend, log);
        result.device = backend.figures();
        result.mesh = surface_of(cut, view, config.surface);
        result.left_bounds = bounds_of(result.mesh.positions);
        if (config.surface.views == SurfaceViews::both && view.is_whole)
            add_other_views(result, view, config, backend, log);
        result.bounds = bounds_of(result.mesh.positions);
        log.decide("depth: " + fixed(result.nearest(), 3) + " to " + fixed(result.farthest(), 3) +
                   (view.calibration.metric ? " m" : " (relative)"));
    });
    result.quality = log.stage("quality", [&] { return quality.get(); });
    result.config = config;
    if (config.exporting.tolerance_share > 0)
        result.config =
            log.stage("tolerance", [&] { return with_tolerance(config, result.mesh, view, threads, log); });
    return result;
}

config::Config with_tolerance(const config::Config& config, const SurfaceMesh& surface, const LeftView& view,
                              int threads, const RunLog& log) {
    config::Config effective = config;
    if (!(config.exporting.tolerance_share > 0)) return effective;
    effective.exporting.tolerance_px =
        tolerance_for(config.exporting, surface, view.disparity, view.density.background_px, threads);
    log.decide("tolerance: " + fixed(effective.exporting.tolerance_px, 3) + " px");
    return effective;
}

void warn_of_inversions(const quality::MeshQuality& quality, RunLog& log) {
    if (quality.inverted_triangles > 0)
        log.warn(std::to_string(quality.inverted_triangles) +
                 " triangles of the 2D mesh are inverted; more iterations (mesh.t_max) may help");
}

std::vector<SurfaceMesh> coarser_levels(const LeftView& view, const SurfaceResult& finest, Backend& backend,
                                        const RunLog& log) {
    std::vector<SurfaceMesh> levels;
    config::Config coarser = finest.config;
    for (int level = 1; level < coarser.exporting.lod; ++level) {
        coarser.mesh.spacing_px *= 2;
        levels.push_back(coarser_level(level, view, coarser, finest, backend, log));
        const SurfaceMesh& mesh = levels.back();
        log.decide("level of detail " + std::to_string(level) + ": " + fixed(coarser.mesh.spacing_px, 1) +
                   " px, " + std::to_string(mesh.positions.size()) + " vertices, " +
                   std::to_string(mesh.triangles.size()) + " triangles");
    }
    return levels;
}

}  // namespace hexrelief::job
