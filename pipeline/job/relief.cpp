#include "pipeline/job/relief.h"

#include "pipeline/checks/pair_support.h"
#include "pipeline/job/pairs/align_pair.h"
#include "pipeline/stages/surface.h"

namespace hexrelief::job {

LeftView Relief::view() const {
    return {disparity.map,
            disparity.meshed(),
            density,
            input.color(),
            input.texture(),
            input.calibration,
            pair_camera,
            disparity.backdrop ? disparity.backdrop->disparity_px : 0,
            right ? &*right : nullptr,
            input.is_whole(),
            input.texture_file.empty() ? nullptr : &input.texture_file,
            input.is_aligned() ? up_if_turned(*input.pair()->alignment) : LeftView::kUpright,
            input.pair() && input.pair()->alignment && has_camera_of_points(*input.pair()->alignment),
            disparity.has_filled_holes,
            disparity.quantum_px};
}

double Relief::depth_of_backdrop() const {
    if (!disparity.backdrop) return 0;
    const Calibration& camera = input.calibration;
    return -stages::position_in_space(0, 0, disparity.backdrop->disparity_px, camera)[2];
}

std::string Relief::support() const {
    return disparity.matched ? checks::support_word(disparity.support) : "";
}

}  // namespace hexrelief::job
