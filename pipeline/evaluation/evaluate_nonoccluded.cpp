#include <algorithm>
#include <cmath>

#include "pipeline/evaluation/evaluate_parts.h"

namespace hexrelief::evaluation {
namespace {

constexpr float kAgreement_px = 1.01f;  // one px, plus rounding

}  // namespace

std::vector<std::uint8_t> find_nonoccluded(const DisparityMap& truth, const DisparityMap* right_truth) {
    const int width = truth.width;
    std::vector<std::uint8_t> nonoccluded(truth.values.size());
    std::vector<float> nearest(width);
    for (int y = 0; y < truth.height; ++y) {
        // Returns the column of the right view in which the pixel is seen; outside the
        // view for unknown pixels.
        const auto right_column = [&](int x) {
            return is_given(truth.at(x, y)) ? x - static_cast<int>(std::nearbyint(truth.at(x, y))) : -1;
        };
        std::fill(nearest.begin(), nearest.end(), -kUnknownDisparity);
        for (int x = 0; x < width && !right_truth; ++x)
            if (const int xr = right_column(x); xr >= 0 && xr < width)
                nearest[xr] = std::max(nearest[xr], truth.at(x, y));
        for (int x = 0; x < width; ++x) {
            const int xr = right_column(x);
            if (xr < 0 || xr >= width) continue;
            const float d = truth.at(x, y);
            nonoccluded[static_cast<std::size_t>(y) * width + x] =
                right_truth ? is_given(right_truth->at(xr, y)) &&
                                  std::fabs(right_truth->at(xr, y) - d) <= kAgreement_px
                            : d >= nearest[xr] - kAgreement_px;
        }
    }
    return nonoccluded;
}

}  // namespace hexrelief::evaluation
