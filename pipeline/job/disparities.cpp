#include "pipeline/job/disparities.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "pipeline/checks/pair_statistics.h"
#include "pipeline/checks/thresholds.h"
#include "pipeline/data/calibration.h"
#include "pipeline/data/error.h"
#include "pipeline/job/cameras/resolve_calibration.h"
#include "pipeline/job/maps/disparity_input.h"
#include "pipeline/job/matchers/given_maps.h"
#include "pipeline/job/pairs/align_pair.h"
#include "pipeline/job/pairs/working_size.h"
#include "pipeline/stages/by_colour/bare_borders.h"
#include "pipeline/stages/by_colour/bare_patches.h"
#include "pipeline/stages/by_colour/filled_rims.h"
#include "pipeline/stages/by_colour/frame_pieces.h"
#include "pipeline/stages/by_colour/mixed_pixels.h"
#include "pipeline/stages/by_colour/rim_strips.h"
#include "pipeline/stages/by_colour/rims.h"
#include "pipeline/stages/densify/densify.h"
#include "pipeline/stages/densify/measurements.h"
#include "pipeline/stages/dequantize/dequantize.h"
#include "pipeline/stages/dequantize/noise.h"

namespace hexrelief::job {
namespace {

constexpr double kMostUnknown = 0.25;  // share of a map that has holes, and is not a thing cut out

std::string percent_of(double share) {
    return fixed(100 * share, 1) + " %";
}

void check_any_match(const DisparityMap& map) {
    check_matches(std::ranges::find(map.origins, PixelOrigin::matched) != map.origins.end());
}

// Returns a supplied map whose blurred steps are cut along the picture's edges (stages::sharpen_steps()).
DisparityMap sharpen_map(DisparityMap map, const Image& left, int threads, const RunLog& log) {
    stages::SharpenedMap sharp = stages::sharpen_steps(std::move(map), left, threads);
    if (sharp.blurred_share > 0)
        log.decide("disparity: steps are blurred; " + percent_of(sharp.blurred_share) +
                   " of the pixels lie on them, and are cut along the picture's edges");
    return std::move(sharp.map);
}

// Returns a supplied map of the pair's left view, checked by the right picture (check_by_picture()); as it is
// if that picture shows something else, with a warning.
DisparityMap check_map(DisparityMap map, StereoPair pair, const stages::DisparityConfig& config, int threads,
                       RunLog& log) {
    constexpr double another_scene = 0.2;  // faulty maps have up to 0.13, wrong pictures 0.28 and more
    PictureCheck check =
        log.stage("check", [&] { return check_by_picture(std::move(pair), map, config, threads); });
    const std::string share = percent_of(check.unlike_share);
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

// Returns a supplied map. A sparse map is filled between its measurements in a stage of its own, except at
// the pixels that the mask hides; only then the result has origins. left, mask: empty = none.
DisparityMap densify_map(DisparityMap map, const Image& left, const readers::PixelMask& mask, int threads,
                         RunLog& log) {
    const stages::Sparsity sparsity = stages::measure_sparsity(map);
    if (!sparsity.is_sparse()) return map;
    DisparityMap dense = log.stage("densify", [&] {
        DisparityMap filled = stages::densify(map, left, threads);
        hide(filled, mask);
        return filled;
    });
    log.decide("densify: " + percent_of(sparsity.known_share) +
               " of the pixels are known, with unknown ones between them; " +
               percent_of(stages::measure_sparsity(dense).known_share) + " are known when filled" +
               (left.empty() ? "" : ", by the picture's colours"));
    return dense;
}

// Removes the quantisation steps from a supplied map, unless max_error_px is above 0 and less than a step.
DisparityResult smooth_map(DisparityMap map, double max_error_px, int threads, const RunLog& log) {
    DisparityResult result{std::move(map), std::nullopt};
    const double quantum_px = stages::find_quantum_px(result.map);
    if (quantum_px == 0 || (max_error_px > 0 && max_error_px < quantum_px)) return result;
    result.quantum_px = quantum_px;
    result.smooth = stages::dequantize(result.map, quantum_px, threads);
    log.decide("disparity: smoothed within its steps of " + fixed(quantum_px, 3) + " px");
    return result;
}

// Fills the pixels that a supplied map does not know but its picture shows, by planes, except those that the
// mask hides. Does nothing if more than a quarter of the map is unknown, or if there is no picture.
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
    log.decide("disparity: " + percent_of(static_cast<double>(unknown) / static_cast<double>(all)) +
               " were unknown, and lie on the planes around them");
}

// Moves what is nearer than nearest_px, which the matches do not support, to what is around it.
void press_near(DisparityResult& disparity, double nearest_px, const RunLog& log) {
    const std::size_t moved = stages::press_near(disparity.map, nearest_px);
    if (moved > 0)
        log.decide("disparity: " + std::to_string(moved) + " px seemed nearer than the " +
                   fixed(nearest_px, 2) + " px that matches support, and lie where their surroundings do");
}

// Refines the map of photographs by themselves (dequantize/dequantize.h) if their points say their camera
// and the map is noisy (dequantize/noise.h).
void refine_noisy(DisparityResult& disparity, const InputPair& pair, int threads, const RunLog& log) {
    if (!disparity.matched || !pair.is_of_points()) return;
    const auto noise = stages::smoothing_for(
        stages::find_noise_px(disparity.map, threads),
        pair.alignment->is_relief() ? stages::kLeastNoiseOfRelief_px : stages::kLeastNoise_px);
    if (noise.noise_px > 0) disparity.map = stages::refine_by_pictures(disparity.map, pair.views, threads);
    disparity.map = stages::with_filled_rims_joined(std::move(disparity.map), pair.views.left, threads);
    disparity.map = stages::without_mixed_pixels(
        stages::with_rims_by_colour(std::move(disparity.map), pair.views.left, threads), pair.views.left,
        stages::Scraps::go);
    if (noise.noise_px == 0) return;
    disparity.noise = noise;
    log.decide("disparity: refined by the pictures, as its noise was " + fixed(noise.noise_px, 3) + " px");
}

// Makes a relief no deeper than its matches and its noise let (flattened(), pipeline/job/pairs/align_pair.h).
void flatten_relief(const DisparityResult& disparity, const InputPair& pair, Calibration& camera,
                    const RunLog& log) {
    const ReliefMap relief{disparity.map, disparity.noise.noise_px, pair.reduced_by};
    const double before_px = std::exchange(camera, flattened(camera, *pair.alignment, relief)).doffs_px;
    if (camera.doffs_px == before_px) return;
    log.decide("disparity: deeper than matches or noise let, so infinity is taken to be at " +
               fixed(-camera.doffs_px, 2) + " px");
}

// Smooths a matched map within its noise (dequantize/noise.h), if there is much and nothing refined it.
void smooth_noise(DisparityResult& disparity, int threads, const RunLog& log) {
    if (!disparity.matched || disparity.noise.noise_px > 0) return;
    const auto noise = stages::smoothing_for(stages::find_noise_px(disparity.map, threads));
    if (noise.noise_px == 0) return;
    disparity.noise = noise;
    disparity.map = stages::dequantize(disparity.map, noise.quantum_px, threads);
    log.decide("disparity: smoothed within its noise of " + fixed(noise.noise_px, 3) + " px");
}

stages::Pictures kind_of(const InputPair& pair) {
    return pair.is_of_points() ? stages::Pictures::photographs : stages::Pictures::rectified;
}

ViewSize size_of(const Image& image) {
    return {image.width, image.height};
}

}  // namespace

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

DisparityResult disparities_of_pair(const InputPair& pair, const StereoPair& corrected,
                                    const stages::DisparityConfig& searched, Backend& backend) {
    check_detail(checks::is_blank(pair.views.left), checks::is_blank(pair.views.right));
    DisparityResult result{
        stages::match_range(corrected, searched, backend, backend.threads(), kind_of(pair)), searched};
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

void sharpen_maps(stages::ViewMaps& maps, const StereoPair& pair, int threads, const RunLog& log) {
    if (!maps.is_dense) return;
    maps.left = sharpen_map(std::move(maps.left), pair.left, threads, log);
    maps.right = stages::sharpen_steps(std::move(maps.right), pair.right, threads).map;
}

void judge_support(DisparityResult& disparity, const InputPair& pair, const readers::PixelMask& mask,
                   bool strict, int threads, RunLog& log) {
    disparity.support =
        checks::measure_support(pair.views.left, disparity.map, mask.kept, pair.right_mask.kept, threads);
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

DisparityResult supplied_disparities(InputMap& input, const readers::PixelMask& mask,
                                     const config::Config& config, int threads, RunLog& log) {
    DisparityMap map = std::move(input.disparities);
    if (config.input.densify == config::Densification::automatic)
        map = densify_map(std::move(map), input.color, mask, threads, log);
    if (!input.color.empty() && map.origins.empty() && config.disparity.fill == stages::DisparityFill::planes)
        map = sharpen_map(std::move(map), input.color, threads, log);
    if (input.right.values.empty() && !input.right_color.empty())
        map = check_map(std::move(map), {input.color, std::move(input.right_color)}, config.disparity,
                        threads, log);
    DisparityResult result = config.disparity.dequantize == stages::Dequantization::none
                                 ? DisparityResult{std::move(map), {}}
                                 : smooth_map(std::move(map), config.budget.max_error_px, threads, log);
    if (config.disparity.fill == stages::DisparityFill::planes)
        fill_map(result, input.color, mask, threads, log);
    return result;
}

stages::OtherView supplied_right_view(InputMap& input, const config::Config& config, int threads,
                                      RunLog& log) {
    InputMap map{std::move(input.right), std::move(input.right_color)};
    DisparityResult result = supplied_disparities(map, {}, config, threads, log);
    return {{},
            result.quantum_px > 0 ? std::move(result.smooth) : std::move(result.map),
            {},
            std::move(map.color),
            std::move(input.right_picture)};
}

void end_scene(DisparityResult& disparity, const Calibration& calibration, const SurfaceConfig& config,
               const RunLog& log) {
    if (!disparity.matched || config.farthest == 0) return;
    disparity.backdrop = stages::put_backdrop(disparity.map, disparity.matched->min_disparity_px,
                                              calibration.doffs_px, config.farthest);
    if (disparity.backdrop)
        log.decide("disparity: the backdrop is at " + fixed(disparity.backdrop->disparity_px, 2) + " px; " +
                   percent_of(disparity.backdrop->moved_share) + " seemed farther");
}

void count_from_infinity(DisparityResult& disparity, Calibration& calibration, bool always,
                         const RunLog& log) {
    const auto is_far = [](float d) { return DisparityMap::known(d) && d <= 0; };
    const std::vector<float>& values = disparity.map.values;
    if (calibration.doffs_px <= 0 || (!always && std::ranges::none_of(values, is_far))) return;
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
    std::vector<float> known = known_values(map, kEvery);
    if (known.empty()) return 1;
    const double from_infinity_px = std::max(value_at_rank(known, known.size() / 2) + camera.doffs_px, 1e-3);
    return std::clamp(std::round(10 * tangent * camera.focal_px / from_infinity_px) / 10, 1.0, most);
}

void finish_disparities(Relief& relief, config::Config& config, RunLog& log) {
    const InputPair* const pair = relief.input.pair();
    DisparityResult& disparity = relief.disparity;
    Calibration& camera = relief.input.calibration;
    const int threads = relief.backend->threads();
    const bool is_smoothed = config.disparity.dequantize == stages::Dequantization::automatic;
    const bool is_of_points = pair && pair->is_of_points();
    if (pair && pair->alignment) {
        press_near(disparity, nearest_px(*pair->alignment) / pair->reduced_by, log);
        if (is_of_points)
            disparity.map = stages::with_bare_patches_behind(
                stages::continued_at_right_end(std::move(disparity.map), pair->views.left,
                                               pair->right_mask.kept, threads),
                pair->views.left, threads);
        if (is_smoothed) refine_noisy(disparity, *pair, threads, log);
        if (is_smoothed && is_of_points)
            disparity.map = stages::with_wider_near(
                stages::with_frame_pieces_joined(std::move(disparity.map), threads), threads);
        flatten_relief(disparity, *pair, camera, log);
    }
    if (pair)
        disparity.map = stages::with_bare_borders_behind(std::move(disparity.map), pair->views.left,
                                                         kind_of(*pair), threads);
    if (is_smoothed && is_of_points) disparity.map = stages::with_rim_strips_joined(std::move(disparity.map));
    relief.pair_camera = camera;
    end_scene(disparity, camera, config.surface, log);
    count_from_infinity(disparity, camera, relief.input.is_aligned(), log);
    if (pair && !config.given.contains("surface.behind"))
        config.surface.behind = baselines_of_turn(disparity.map, camera, is_of_points);
    if (is_smoothed) smooth_noise(disparity, threads, log);
}

int find_reduction(const RunInput& input, const stages::DisparityConfig& config, int threads,
                   const RunLog& log) {
    const InputPair* const pair = input.pair();
    const int least = pair ? reduction_of(pair->views.left, config.working_px) : 1;
    const bool is_of_points = pair && pair->is_of_points();
    const int by = is_of_points ? reduction_of_soft(pair->views.left, config.working_px, threads) : least;
    if (by == 1) return by;
    const ViewSize full = size_of(pair->views.left);
    log.decide("working size: the pair of " + size_text(full) + " px is matched and meshed at " +
               size_text(ViewSize{full.width / by, full.height / by}) + " px (disparity.working_px" +
               (by > least ? ", its pictures are soft" : "") + "); the texture keeps its size");
    return by;
}

void reduce_pair(RunInput& input, const stages::DisparityConfig& config, int threads, const RunLog& log) {
    const int by = find_reduction(input, config, threads, log);
    if (by == 1) return;
    auto* const pair = std::get_if<InputPair>(&input.views);
    stages::check_matchable(pair->views, config);
    auto [views, pictures] = reduced(std::move(pair->views), by, threads);
    Calibration& camera = input.calibration;
    camera.width = pictures.left.width;
    camera.height = pictures.left.height;
    camera = scaled_to(camera, size_of(views.left));
    input.mask = reduced(input.mask, by);
    pair->right_mask = reduced(pair->right_mask, by);
    pair->views = std::move(views);
    pair->pictures = std::move(pictures);
    pair->reduced_by = by;
}

}  // namespace hexrelief::job
