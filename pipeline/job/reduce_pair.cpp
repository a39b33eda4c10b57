#include <utility>

#include "pipeline/data/calibration.h"
#include "pipeline/job/cameras/resolve_calibration.h"
#include "pipeline/job/input.h"
#include "pipeline/job/pairs/align_pair.h"
#include "pipeline/job/pairs/working_size.h"

namespace hexrelief::job {
namespace {

ViewSize size_of(const Image& image) {
    return {image.width, image.height};
}

}  // namespace

int find_reduction(const RunInput& input, const stages::DisparityConfig& config, int threads,
                   const RunLog& log) {
    const InputPair* const pair = input.pair();
    const int least = pair ? reduction_of(pair->views.left, config.working_px) : 1;
    const bool is_of_points = pair && pair->alignment && has_camera_of_points(*pair->alignment);
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
