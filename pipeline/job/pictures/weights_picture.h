// A histogram of the honeycomb cells' shares of the density.
#pragma once

#include <vector>

#include "pipeline/data/image.h"

namespace hexrelief::job {

// Returns the shares of the weights (>= 0) in bins of W_k / mean, each 0.05 wide: bin i is centred at 0.05 i,
// the last one (2) holds all larger ones. Empty if there is no weight or all are 0.
std::vector<double> weight_shares(const std::vector<double>& weights);

// Draws the bins as bars from 0 (left) to 2 (right) times the mean, with lines at 0.5, 1 (red) and
// 1.5. A bar's height is proportional to the square root of its share, so that single cells are
// visible. 820 x 400 px.
Image weights_picture(const std::vector<double>& weights);

}  // namespace hexrelief::job
