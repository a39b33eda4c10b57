// How a disparity map compares with ground truth.
#include <cmath>
#include <string>

#include "pipeline/data/error.h"
#include "pipeline/stages/disparity.h"

namespace hexrelief {

DisparityEvaluation evaluate_disparity(const DisparityMap& map, const DisparityMap& truth) {
    if (map.width != truth.width || map.height != truth.height) {
        throw Error(ErrorKind::input, "the disparity map is " + std::to_string(map.width) + "x" +
                                          std::to_string(map.height) + ", its ground truth " +
                                          std::to_string(truth.width) + "x" + std::to_string(truth.height) +
                                          "; give two maps of one size");
    }
    long long known = 0, bad[4] = {};
    double sum = 0, squares = 0;
    DisparityEvaluation result;
    for (std::size_t i = 0; i < truth.values.size(); ++i) {
        if (!DisparityMap::known(truth.values[i])) continue;
        ++result.truth_pixels;
        double error = std::numeric_limits<double>::infinity();
        if (DisparityMap::known(map.values[i])) {
            error = std::fabs(static_cast<double>(map.values[i]) - truth.values[i]);
            ++known;
            sum += error;
            squares += error * error;
        }
        for (int k = 0; k < 4; ++k) bad[k] += error > kBadThresholds_px[k];
    }
    if (result.truth_pixels == 0) {
        throw Error(ErrorKind::input,
                    "the ground truth has no known pixel; check its scale and unknown value");
    }
    for (int k = 0; k < 4; ++k) result.bad_percent[k] = 100.0 * bad[k] / result.truth_pixels;
    result.coverage_percent = 100.0 * known / result.truth_pixels;
    if (known > 0) {
        result.average_error_px = sum / known;
        result.rms_error_px = std::sqrt(squares / known);
    }
    return result;
}

}  // namespace hexrelief
